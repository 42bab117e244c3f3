!> Rest positions: poses in which the forces of contacts, springs, gravity and applied loads on
!> every body that is free to move balance, without friction and at rest.
!>
!> The coordinates are translations and rotations of bodies, F the loads along them and K = -dF/dx
!> their stiffness, from the derivatives of the contacts. Newton's method with K + l D, D the
!> stiffness of the body and l the first of 0, 1e-10, 1e-8, ... that makes it positive definite, so
!> that a step goes to a minimum of the energy, and neutral coordinates are moved as little as
!> possible (K. Levenberg, Q. Appl. Math. 2 (1944) 164). A step is shortened until the loads along
!> it do not turn round by more than half.
module contensou_dynamics_statics
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : quaternion_from_axis_angle, rotation_matrix
   use contensou_base_vectors, only : cross
   use contensou_dynamics_assembly, only : assemble, initial_pose
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_linear_load, only : linear_load_type, linearize
   use contensou_dynamics_scene, only : scene_type
   use contensou_dynamics_springs, only : spring_load_type
   use contensou_special_elimination, only : factorize, solve_factorized, solve_with_gaps
   implicit none(type, external)
   private

   public :: coordinate_type, statics_type, assemble_statics, begin_statics, find_rest, &
      find_stiffness, reduced

   !> A way in which a body can move.
   type :: coordinate_type
      integer :: body = 0
      !> Unit vector, inertial frame: of a translation, or of a rotation about the centre of mass.
      real(wp) :: direction(3) = 0.0_wp
      logical :: turns = .false.
      !> Whether the direction turns with the body.
      logical :: follows = .false.
   end type coordinate_type

   !> Loads and stiffness of a system at rest.
   type :: statics_type
      type(coordinate_type), allocatable :: coordinates(:)
      !> Loads along the coordinates [N, N m].
      real(wp), allocatable :: load(:)
      !> What they are made of, without cancelling [N, N m].
      real(wp), allocatable :: scale(:)
      !> Stiffness K [N/m, N, N m/rad].
      real(wp), allocatable :: stiffness(:, :)
      !> Stiffness of the body along a coordinate, whatever its direction.
      real(wp), allocatable :: reference(:)
      !> Coordinates along which there is neither a load nor stiffness.
      logical, allocatable :: neutral(:)
      !> Largest load that is left, over what it is made of [-].
      real(wp) :: residual = huge(1.0_wp)
      integer :: iterations = 0
      !> Whether the loads balance.
      logical :: balanced = .false.
      !> Body on which they balance least.
      integer :: body = 0
      !> Where the coordinates of each body begin among their numbers, and one beyond the last.
      integer, allocatable, private :: first(:), members(:)
      !> Sizes of the forces on each body [N], and its largest stiffness against a contact or a
      !> spring [N/m].
      real(wp), allocatable, private :: carried(:), firm(:)
   end type statics_type

   !> Stiffness, over that of the body, and load, over what it is made of, that are rounding.
   real(wp), parameter :: nothing = 1.0e-13_wp

   !> Pivot over the stiffness of the body that counts as positive.
   real(wp), parameter :: definite = 1.0e-12_wp

   !> Load that is left, over what it is made of, of a rest position.
   real(wp), parameter :: balanced_to = 1.0e-8_wp

   !> Rounding of a position that its body's loads cannot tell from balance.
   real(wp), parameter :: position_ulps = 100.0_wp

   !> Largest step over the approach that a contact admits.
   real(wp), parameter :: longest = 0.25_wp

   integer, parameter :: most_iterations = 2000

contains

   !> Equations of motion of a scene without friction, damping and rolling resistance, its bodies at
   !> rest where they begin.
   subroutine assemble_statics(scene, system)
      type(scene_type), intent(in) :: scene
      type(system_type), intent(out) :: system
      type(scene_type) :: bare
      integer :: i

      bare = scene
      bare%contacts%damping = 1
      bare%contacts%friction = 1
      bare%contacts%rolling = 1
      bare%contacts%tangential = 1
      call assemble(bare, system)
      do i = 1, size(scene%bodies)
         system%pose(i) = initial_pose(scene, i)
         system%pose(i)%velocity = 0.0_wp
         system%pose(i)%spin = 0.0_wp
      end do
   end subroutine assemble_statics

   !> Bring bodies to rest along coordinates.
   subroutine find_rest(system, coordinates, statics)
      !> The system without friction; its poses are changed.
      type(system_type), intent(inout) :: system
      type(coordinate_type), intent(in) :: coordinates(:)
      !> Loads and stiffness there; not balanced if there is no rest position.
      type(statics_type), intent(out) :: statics
      real(wp) :: step(size(coordinates)), best, along, ahead, share, limit
      integer :: i, stalled
      logical :: good

      statics%coordinates = coordinates
      limit = longest*minval([(system%contacts(i)%law%largest_approach, i=1, &
         size(system%contacts)), 1.0_wp])
      best = huge(best)
      stalled = 0
      do i = 1, most_iterations
         statics%iterations = i
         call find_stiffness(system, statics, good)
         if (.not. good) exit
         if (statics%residual < 0.5_wp*best) then
            best = statics%residual
            stalled = 0
         else
            stalled = stalled + 1
         end if
         statics%balanced = statics%residual <= balanced_to
         if (statics%residual <= nothing) exit
         if (statics%balanced .and. stalled > 3) exit
         call newton_step(statics, step, good)
         if (.not. good) exit
         share = min(1.0_wp, limit/max(longest_move(system, statics, step), tiny(share)))
         along = dot_product(step, statics%load)
         if (negligible(system, statics, share*step)) exit
         do
            call move(system, statics, share*step)
            call find_loads(system, statics, good)
            ahead = 0.0_wp
            if (good) ahead = dot_product(step, statics%load)
            if (good .and. ahead >= -0.5_wp*abs(along)) exit
            call move(system, statics, -share*step)
            share = 0.5_wp*share
            if (negligible(system, statics, share*step)) exit
         end do
      end do
      call find_stiffness(system, statics, good)
      statics%balanced = good .and. statics%residual <= balanced_to
   end subroutine find_rest

   !> Newton's step, with as little added to the stiffness as makes it definite.
   subroutine newton_step(statics, step, good)
      type(statics_type), intent(in) :: statics
      real(wp), intent(out) :: step(:)
      !> Whether there is one.
      logical, intent(out) :: good
      real(wp) :: matrix(size(step), size(step)), added
      integer :: free(size(step)), n, i, j, k

      step = 0.0_wp
      n = 0
      do i = 1, size(step)
         if (statics%neutral(i)) cycle
         n = n + 1
         free(n) = i
      end do
      added = 0.0_wp
      do k = 0, 8
         do j = 1, n
            do i = j, n
               matrix(i, j) = 0.5_wp*(statics%stiffness(free(i), free(j)) &
                  + statics%stiffness(free(j), free(i)))
            end do
            matrix(j, j) = matrix(j, j) + added*statics%reference(free(j))
         end do
         call factorize(n, matrix, definite*statics%reference(free(:n)), good)
         if (good) exit
         added = max(1.0e-10_wp, 100.0_wp*added)
      end do
      if (.not. good) return
      step(:n) = statics%load(free(:n))
      call solve_factorized(n, matrix, step)
      step(free(:n)) = step(:n)
      do i = 1, size(step)
         if (all(free(:n) /= i)) step(i) = 0.0_wp
      end do
   end subroutine newton_step

   !> Longest way that a step moves a point of a body at the arm of its contacts [m].
   pure real(wp) function longest_move(system, statics, step) result(longest_way)
      type(system_type), intent(in) :: system
      type(statics_type), intent(in) :: statics
      real(wp), intent(in) :: step(:)
      integer :: i

      longest_way = 0.0_wp
      do i = 1, size(step)
         associate (coordinate => statics%coordinates(i))
            if (coordinate%turns) then
               longest_way = max(longest_way, abs(step(i))*arm_of(system, coordinate%body))
            else
               longest_way = max(longest_way, abs(step(i)))
            end if
         end associate
      end do
   end function longest_move

   !> Whether a step is within the rounding of positions and rotations.
   pure logical function negligible(system, statics, step)
      type(system_type), intent(in) :: system
      type(statics_type), intent(in) :: statics
      real(wp), intent(in) :: step(:)
      real(wp) :: rounding
      integer :: i

      negligible = .false.
      do i = 1, size(step)
         associate (coordinate => statics%coordinates(i))
            if (coordinate%turns) then
               rounding = epsilon(rounding)
            else
               rounding = maxval(spacing(system%pose(coordinate%body)%position), &
                  mask=abs(coordinate%direction) > 0.0_wp)
            end if
            if (abs(step(i)) > rounding) return
         end associate
      end do
      negligible = .true.
   end function negligible

   !> Length at which the loads of a body act [m].
   pure real(wp) function arm_of(system, body) result(arm)
      type(system_type), intent(in) :: system
      integer, intent(in) :: body
      integer :: i

      arm = 0.0_wp
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            if (contact%a /= body .and. contact%b /= body) cycle
            arm = max(arm, min(contact%law%geometry%smallest_radius(), 1.0_wp), &
               min(contact%reach(merge(1, 2, contact%a == body)), 1.0_wp))
         end associate
      end do
      do i = 1, size(system%springs)
         associate (spring => system%springs(i))
            if (spring%a == body) arm = max(arm, norm2(spring%point(:, 1)))
            if (spring%b == body) arm = max(arm, norm2(spring%point(:, 2)))
         end associate
      end do
      if (.not. arm > 0.0_wp) arm = 1.0_wp
   end function arm_of

   !> Move bodies along their coordinates.
   subroutine move(system, statics, step)
      type(system_type), intent(inout) :: system
      !> The coordinates; those that follow their bodies turn.
      type(statics_type), intent(inout) :: statics
      real(wp), intent(in) :: step(:)
      real(wp) :: turn(3, size(system%bodies)), rotation(3, 3)
      integer :: i

      turn = 0.0_wp
      do i = 1, size(step)
         associate (coordinate => statics%coordinates(i))
            if (coordinate%turns) then
               turn(:, coordinate%body) = turn(:, coordinate%body) + step(i)*coordinate%direction
            else
               associate (pose => system%pose(coordinate%body))
                  pose%position = pose%position + step(i)*coordinate%direction
               end associate
            end if
         end associate
      end do
      do i = 1, size(system%bodies)
         if (.not. any(abs(turn(:, i)) > 0.0_wp)) cycle
         rotation = rotation_matrix(quaternion_from_axis_angle(turn(:, i), norm2(turn(:, i))))
         system%pose(i)%rotation = matmul(rotation, system%pose(i)%rotation)
      end do
      do i = 1, size(step)
         associate (coordinate => statics%coordinates(i))
            if (.not. coordinate%follows) cycle
            if (.not. any(abs(turn(:, coordinate%body)) > 0.0_wp)) cycle
            rotation = rotation_matrix(quaternion_from_axis_angle(turn(:, coordinate%body), &
               norm2(turn(:, coordinate%body))))
            coordinate%direction = matmul(rotation, coordinate%direction)
         end associate
      end do
   end subroutine move

   !> Loads along the coordinates.
   subroutine find_loads(system, statics, good)
      type(system_type), intent(inout) :: system
      type(statics_type), intent(inout) :: statics
      !> Whether all contacts are in their domain.
      logical, intent(out) :: good
      integer :: i

      call system%static_loads()
      good = .not. system%outside
      if (.not. good) return
      do i = 1, size(statics%coordinates)
         associate (coordinate => statics%coordinates(i), &
            load => system%load(statics%coordinates(i)%body))
            statics%load(i) = dot_product(coordinate%direction, merge(load%torque, load%force, &
               coordinate%turns))
         end associate
      end do
   end subroutine find_loads

   !> Loads and stiffness along the coordinates.
   subroutine find_stiffness(system, statics, good, exactly)
      type(system_type), intent(inout) :: system
      type(statics_type), intent(inout) :: statics
      !> Whether all contacts are in their domain.
      logical, intent(out) :: good
      !> Whether no digit of the stiffness is to be lost in differences; not if not given.
      logical, intent(in), optional :: exactly
      type(linear_load_type) :: load
      type(spring_load_type) :: found
      integer :: i, n
      logical :: closed

      n = size(statics%coordinates)
      if (.not. allocated(statics%load)) allocate(statics%load(n), statics%scale(n), &
         statics%stiffness(n, n), statics%reference(n), statics%neutral(n), statics%members(n), &
         statics%first(size(system%bodies) + 1), statics%carried(size(system%bodies)), &
         statics%firm(size(system%bodies)))
      call list_coordinates(statics%coordinates, statics%first, statics%members)
      call find_loads(system, statics, good)
      if (.not. good) return
      statics%stiffness = 0.0_wp
      statics%carried = 0.0_wp
      statics%firm = 0.0_wp
      do i = 1, size(system%contacts)
         associate (contact => system%contacts(i))
            if (contact%rigid) cycle
            call linearize(contact, system%pose(contact%a), system%pose(contact%b), &
               system%resolution, load, closed, exactly)
            if (closed) call add_pair(statics, contact%a, contact%b, load%force, load%slopes)
         end associate
      end do
      do i = 1, size(system%springs)
         associate (spring => system%springs(i))
            call spring%vary(system%pose(spring%a), system%pose(spring%b), found, &
               load%slopes(:, :24))
            call add_pair(statics, spring%a, spring%b, found%force, load%slopes)
         end associate
      end do
      do i = 1, size(system%bodies)
         associate (body => system%bodies(i))
            statics%carried(i) = statics%carried(i) + norm2(body%mass*system%gravity)
            if (.not. body%loaded) cycle
            statics%carried(i) = statics%carried(i) + norm2(body%force)
            if (body%load_follows) call add_following(system, statics, i)
         end associate
      end do
      call weigh_loads(system, statics)
   end subroutine find_stiffness

   !> Begin anew, with coordinates.
   pure subroutine begin_statics(statics, coordinates)
      type(statics_type), intent(out) :: statics
      type(coordinate_type), intent(in) :: coordinates(:)

      statics%coordinates = coordinates
   end subroutine begin_statics

   !> Sizes of loads and stiffness along the coordinates, and where the loads balance least.
   subroutine weigh_loads(system, statics)
      type(system_type), intent(in) :: system
      type(statics_type), intent(inout) :: statics
      real(wp) :: arm, left, least
      integer :: i

      ! A body that nothing touches yields as far as the others let it.
      statics%firm = max(statics%firm, 1.0e-6_wp*max(maxval(statics%firm), &
         maxval(statics%carried)), tiny(1.0_wp))
      statics%residual = 0.0_wp
      statics%body = 0
      do i = 1, size(statics%coordinates)
         associate (coordinate => statics%coordinates(i))
            arm = 1.0_wp
            if (coordinate%turns) arm = arm_of(system, coordinate%body)
            ! A body that carries nothing touches others by the rounding of its position.
            least = position_ulps*statics%firm(coordinate%body) &
               *maxval(spacing(system%pose(coordinate%body)%position))/balanced_to
            statics%scale(i) = max(statics%carried(coordinate%body), least)*arm
            if (coordinate%turns) statics%scale(i) = statics%scale(i) &
               + norm2(system%bodies(coordinate%body)%torque)
            statics%reference(i) = statics%firm(coordinate%body)*arm**2
            statics%neutral(i) = maxval(abs(statics%stiffness(i, :))) <= &
               nothing*statics%reference(i) .and. abs(statics%load(i)) <= nothing*statics%scale(i)
            left = 0.0_wp
            if (statics%scale(i) > 0.0_wp) left = abs(statics%load(i))/statics%scale(i)
            if (left <= statics%residual) cycle
            statics%residual = left
            statics%body = coordinate%body
         end associate
      end do
   end subroutine weigh_loads

   !> Add what acts between two bodies.
   subroutine add_pair(statics, a, b, force, slopes)
      type(statics_type), intent(inout) :: statics
      !> The bodies; 0 is the ground.
      integer, intent(in) :: a
      integer, intent(in) :: b
      real(wp), intent(in) :: force(3)
      !> Derivatives of force on B and torques on A and B by the motion of both.
      real(wp), intent(in) :: slopes(:, :)
      integer :: pair(2), row, column, k, m, before
      real(wp) :: force_slope(3), torque_slope(3)

      pair = [a, b]
      do column = 1, 2
         if (pair(column) == 0) cycle
         statics%carried(pair(column)) = statics%carried(pair(column)) + norm2(force)
         before = 12*(column - 1)
         statics%firm(pair(column)) = max(statics%firm(pair(column)), maxval(abs(slopes(1:3, &
            before + 1:before + 3))))
         do m = statics%first(pair(column)), statics%first(pair(column) + 1) - 1
            associate (by => statics%coordinates(statics%members(m)))
               if (by%turns) then
                  force_slope = matmul(slopes(1:3, before + 4:before + 6), by%direction)
               else
                  force_slope = matmul(slopes(1:3, before + 1:before + 3), by%direction)
               end if
               do row = 1, 2
                  if (pair(row) == 0) cycle
                  if (by%turns) then
                     torque_slope = matmul(slopes(3*row + 1:3*row + 3, before + 4:before + 6), &
                        by%direction)
                  else
                     torque_slope = matmul(slopes(3*row + 1:3*row + 3, before + 1:before + 3), &
                        by%direction)
                  end if
                  do k = statics%first(pair(row)), statics%first(pair(row) + 1) - 1
                     associate (of => statics%coordinates(statics%members(k)), &
                        entry => statics%stiffness(statics%members(k), statics%members(m)))
                        if (of%turns) then
                           entry = entry - dot_product(of%direction, torque_slope)
                        else if (row == 1) then
                           entry = entry + dot_product(of%direction, force_slope)
                        else
                           entry = entry - dot_product(of%direction, force_slope)
                        end if
                     end associate
                  end do
               end do
            end associate
         end do
      end do
   end subroutine add_pair

   !> Add a load that turns with its body.
   subroutine add_following(system, statics, index)
      type(system_type), intent(in) :: system
      type(statics_type), intent(inout) :: statics
      integer, intent(in) :: index
      real(wp) :: change(3)
      integer :: k, m

      do m = statics%first(index), statics%first(index + 1) - 1
         associate (by => statics%coordinates(statics%members(m)))
            if (.not. by%turns) cycle
            do k = statics%first(index), statics%first(index + 1) - 1
               associate (of => statics%coordinates(statics%members(k)), &
                  entry => statics%stiffness(statics%members(k), statics%members(m)))
                  change = cross(by%direction, matmul(system%pose(index)%rotation, &
                     merge(system%bodies(index)%torque, system%bodies(index)%force, of%turns)))
                  entry = entry - dot_product(of%direction, change)
               end associate
            end do
         end associate
      end do
   end subroutine add_following

   !> The coordinates body by body.
   pure subroutine list_coordinates(coordinates, first, members)
      type(coordinate_type), intent(in) :: coordinates(:)
      !> Where those of each body begin, and one beyond the last.
      integer, intent(out) :: first(:)
      !> Their numbers.
      integer, intent(out) :: members(:)
      integer :: i, k, n

      n = 0
      do i = 1, size(first) - 1
         first(i) = n + 1
         do k = 1, size(coordinates)
            if (coordinates(k)%body /= i) cycle
            n = n + 1
            members(n) = k
         end do
      end do
      first(size(first)) = n + 1
   end subroutine list_coordinates

   !> Stiffness along some of the coordinates where others yield as they balance: the Schur
   !> complement. Coordinates that no stiffness holds stay.
   subroutine reduced(statics, kept, yielding, matrix)
      type(statics_type), intent(in) :: statics
      !> Coordinates that are kept.
      integer, intent(in) :: kept(:)
      !> Which others yield.
      logical, intent(in) :: yielding(:)
      !> The stiffness.
      real(wp), intent(out) :: matrix(size(kept), size(kept))
      real(wp), allocatable :: inner(:, :), coupling(:, :)
      integer :: others(size(yielding)), n, i

      n = 0
      do i = 1, size(yielding)
         if (.not. yielding(i) .or. statics%neutral(i) .or. any(kept == i)) cycle
         n = n + 1
         others(n) = i
      end do
      matrix = statics%stiffness(kept, kept)
      if (n == 0) return
      inner = statics%stiffness(others(:n), others(:n))
      coupling = statics%stiffness(others(:n), kept)
      call solve_with_gaps(n, inner, coupling, definite*statics%reference(others(:n)))
      matrix = matrix - matmul(statics%stiffness(kept, others(:n)), coupling)
   end subroutine reduced

end module contensou_dynamics_statics
