!> Tangential elasticity of a Hertz spot with local slip and memory: nested shells, each with an
!> elastic displacement of its own and a limit that is convex in force and torque together.
!>
!> A shell between the places x1 < x2, in units of the major semi-axis a, has the share x2 - x1 of
!> the stiffness against shift and S(x2) - S(x1) of that against twist. It slips as the difference
!> of two Hertz spots does: with Phi(v, w) the friction potential of the spot for the friction
!> model of the contact, l(x) = (3/2)(x - x^3/3) the load within x and c(x) = l^(2/3),
!>    phi(v, w) = l2 Phi(v, c2 w) - l1 Phi(v, c1 w),
!> which is convex, as l Phi(v, c(l) w) has a second derivative that grows with l. The potentials of
!> all shells sum to Phi, so full sliding gives the wrench of the friction model for any number of
!> shells. Without twist the shells are the springs of the method of dimensionality reduction
!> (Jaeger 1995, Popov and Hess 2015): many shells follow Cattaneo, Mindlin and Deresiewicz for any
!> history. S(x) makes a pure twist that of Lubkin (1951) on the circle.
!>
!> A step is an elastic trial e, after which each shell slips by the p that solves
!>    K (e - p) in d phi(p):
!> the minimum of the convex phi(p) + (e - p).K(e - p)/2. Formulas, errors: docs/tangential.md.
module contensou_contact_tangential_shells
   use contensou_base_kinds, only : wp
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_abreast, only : abreast, narrow_load
   use contensou_contact_tangential_edges, only : edge_type
   use contensou_contact_tangential_ellipse, only : ellipse_type, least_ratio
   use contensou_contact_tangential_ellipse_pass, only : lanes
   use contensou_contact_tangential_nest, only : make_room, nest_type
   use contensou_contact_tangential_slip, only : shared_type, shell_type, slip_of_shell, &
      sliding_force, stiffness_after, within_rungs
   use contensou_contact_tangential_spot, only : spring_spot_type
   implicit none(type, external)
   private

   public :: shells_type, single_spring, spring_spot_type, default_layers, most_layers, &
      shells_per_layer, inner_ellipsoid, make_room

   !> Below this a limit is none: powers of what is divided by it would leave the range of numbers
   !> [N].
   real(wp), parameter :: no_limit = 1.0e-75_wp

   !> Layers if nothing else is said, and the most.
   integer, parameter :: default_layers = 12, most_layers = 128

   !> Shells in a layer, which slip one after the other.
   integer, parameter :: shells_per_layer = 3

   !> Slip over the elastic displacement below which the stiffness after it is that of this one.
   real(wp), parameter :: shortest_slip = 1.0e-8_wp

   !> Turn of a step and its way below which slip along it turns as it does: beyond them the
   !> direction of the slip is that of the trial.
   real(wp), parameter :: little = 1.0e-3_wp, long_step = 10.0_wp

   !> Load of a shell, in that of the spot, below which its derivatives are but rounding errors.
   real(wp), parameter :: least_load = 1.0e-13_wp

   !> The same below which the direction of its slip is that of the shell inside of it. New area at
   !> the rim bears so little, and its own direction is a difference of what is nearly the same.
   real(wp), parameter :: least_own_load = 1.0e-9_wp

   !> Distance of a shell, in those of its neighbours, over which a direction is extrapolated.
   real(wp), parameter :: farthest_guess = 4.0_wp

   !> The shells of a contact, from the centre to the rim, with what they remember.
   type, extends(nest_type) :: shells_type
      !> What an elliptic spot keeps of the table of sliding.
      type(ellipse_type), private :: ellipse
   contains
      procedure :: begin
      procedure :: advance
      procedure :: slide
   end type shells_type

   !> Directions of the slips of shells from the rim inwards, in a step, and what they make of the
   !> next one.
   type :: course_type
      !> Number of the last shells whose directions are known: from 0 to 2.
      integer :: known = 0
      !> Which of the guesses came closer for the last shell.
      integer :: better = 1
      !> By how much that one was off.
      real(wp) :: off = 1.0_wp
      !> Directions and places of the last shells, the last one first.
      real(wp) :: direction(3, 2) = 0.0_wp, place(2) = 0.0_wp
      !> Changes of their directions since the step before, zero if there was none.
      real(wp) :: change(3, 2) = 0.0_wp
      !> Guesses for the shell at hand: by the change since the step before, and by its neighbours.
      real(wp) :: guess(3, 2) = 0.0_wp
   contains
      procedure :: foresee
      procedure :: note
   end type course_type

contains

   !> Begin without a contact.
   pure subroutine begin(self, layers)
      class(shells_type), intent(inout) :: self
      !> Number of layers, 1 to `most_layers`; `default_layers` if not given.
      integer, intent(in), optional :: layers
      integer :: number

      number = default_layers
      if (present(layers)) number = layers
      call self%clear()
      call make_room(self, shells_per_layer*number)
   end subroutine begin

   !> One spring with the stiffness of the whole spot, as granular codes have it.
   pure function single_spring() result(shells)
      type(shells_type) :: shells

      call make_room(shells, 1)
   end function single_spring

   !> Move the bodies by a step at the load of the spot.
   pure subroutine advance(self, spot, step, wrench, stored, lost, settled, slopes)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Shift of body 1 against body 2 along the axes [m] and twist [rad].
      real(wp), intent(in) :: step(3)
      !> Force along the axes [N] and torque [N m] on body 1.
      real(wp), intent(out) :: wrench(3)
      !> Elastic energy after the step [J].
      real(wp), intent(out), optional :: stored
      !> Work of the slip in the step and what a smaller spot has let go [J], >= 0.
      real(wp), intent(out), optional :: lost
      !> Whether shells are merged and divided so that their number stays, unless that is left to
      !> `settle`: without it the wrench is a continuous function of spot and step.
      logical, intent(in), optional :: settled
      !> Derivatives of the wrench by the step, and by the limit at constant size.
      real(wp), intent(out), optional :: slopes(3, 4)
      real(wp) :: work, way, limit, surely, let_go
      integer :: j, new

      wrench = 0.0_wp
      if (present(slopes)) slopes = 0.0_wp
      call self%resize(spot, lost, settled, new)
      if (present(stored)) stored = 0.0_wp
      if (self%n == 0) return
      if (.not. spot%limit > no_limit) then
         if (present(lost)) lost = lost + self%energy()
         self%shift(:self%n, :) = 0.0_wp
         self%uneven(:self%n) = 0.0_wp
         self%slipped(:self%n) = .false.
         return
      end if
      way = sqrt((spot%stiffness(1)*step(1))**2 + (spot%stiffness(2)*step(2))**2 &
         + (spot%stiffness(3)*step(3)/spot%a)**2)/spot%limit
      self%way = self%way + way
      limit = spot%limit
      surely = inner_ellipsoid(spot%shape%k)*limit
      if (associated(spot%rung)) then
         limit = within_rungs*limit
         surely = 0.0_wp
      end if
      call self%kernels%try_elastic(self%shell_data_type, new, step, limit, surely, &
         spot%a*spot%shape%torque)
      work = 0.0_wp
      if (.not. any(abs(self%shift(:self%n, 3)) > 0.0_wp)) then
         do j = self%n, 1, -abreast
            call let_slip_in_plane(self, max(j - abreast + 1, 1), j, new, spot, work, slopes)
         end do
      else
         if (.not. associated(spot%rung)) then
            if (.not. spot%shape%c > 0.0_wp) then
               call let_slip_on_circle(self, new, spot, step, work, slopes)
            else if (spot%shape%k >= least_ratio) then
               call let_slip_on_ellipse(self, new, spot, step, way, work, slopes)
               call let_rim_follow(self, spot, work)
            end if
         end if
         if (.not. all(self%excess(:self%n) < 0.0_wp)) call let_slip(self, new, spot, work, slopes)
      end if
      if (present(slopes)) call add_springs(self, new, slopes)
      let_go = spot%limit*work
      do j = 1, self%n
         wrench(1) = wrench(1) - self%share(j, 1)*self%shift(j, 1)
         wrench(2) = wrench(2) - self%share(j, 2)*self%shift(j, 2)
         wrench(3) = wrench(3) - self%share(j, 3)*self%shift(j, 3)
         ! The force of what slips is even.
         if (.not. self%slipped(j)) cycle
         let_go = let_go + abs(self%uneven(j))
         self%uneven(j) = 0.0_wp
      end do
      if (present(lost)) lost = lost + let_go
      if (present(stored)) stored = self%energy()
   end subroutine advance

   !> Size of an ellipsoid that is within the limit of any shell, over that through pure sliding and
   !> pure spinning. Shells that bear next to nothing have the least: 0.824 on a needle, 0.836,
   !> 0.852 and 0.868 for k = 0.3, 0.5 and 0.7, and 0.892 on a circle.
   pure real(wp) function inner_ellipsoid(ratio)
      !> Axis ratio, from 0 to 1.
      real(wp), intent(in) :: ratio

      inner_ellipsoid = 0.813_wp + 0.073_wp*ratio
   end function inner_ellipsoid

   !> Part of a step that a shell has: area that is new has come one by one.
   pure real(wp) function part_of_step(j, n, new) result(part)
      !> The shell, the number of all, and of those at the rim that are new.
      integer, intent(in) :: j, n, new

      part = 1.0_wp
      if (j > n - new) part = (real(n - j, wp) + 0.5_wp)/real(new, wp)
   end function part_of_step

   !> Let the shells slip whose trials may be outside of their limits, from the rim inwards.
   pure subroutine let_slip(self, new, spot, work, slopes)
      !> The shells, after their elastic trials.
      class(shells_type), intent(inout) :: self
      !> Number of the shells at the rim that are new.
      integer, intent(in) :: new
      type(spring_spot_type), intent(in) :: spot
      !> Work of the slip over the limit, added to.
      real(wp), intent(inout) :: work
      !> Derivatives of the wrench, added to.
      real(wp), intent(inout), optional :: slopes(3, 4)
      real(wp) :: stiffness(3), trial(3), bearing(3), units(3), per_unit(3), lengths(3), &
         springs(3), fading(3), towards(3), before(3), last(3), done, place
      type(course_type) :: course
      type(shared_type) :: shared
      type(shell_type) :: shell
      logical :: seeks, follows
      integer :: i, j

      ! Units of f N and of lengths.
      units = spot%limit*[1.0_wp, 1.0_wp, spot%a]
      per_unit = 1.0_wp/units
      lengths = units/spot%limit
      springs = spot%limit*per_unit**2
      fading = [1.0_wp, 1.0_wp, self%fading]
      last = 0.0_wp
      ! With rungs a poor first direction costs little.
      seeks = .not. associated(spot%rung)
      shell%shape = spot%shape
      shell%rung => spot%rung
      do j = self%n, 1, -1
         if (self%excess(j) < 0.0_wp) then
            course%known = 0
            cycle
         end if
         do i = 1, 3
            stiffness(i) = self%share(j, i)
            trial(i) = self%shift(j, i)
            bearing(i) = stiffness(i)*trial(i)*per_unit(i)
            before(i) = self%direction(j, i)
         end do
         towards = before
         follows = seeks .and. abs(trial(3)) > 0.0_wp
         if (follows) then
            ! In a unit of its own.
            place = self%edge(j - 1) + self%edge(j)
            call course%foresee(place, before, towards)
         else if (maxval(abs(before)) <= 0.0_wp) then
            towards = last
         end if
         if (follows .and. .not. spot%shape%c > 0.0_wp .and. j < self%n) then
            if (self%slipped(j + 1)) towards = self%direction(j + 1, :)
         end if
         shell%inner = edge_type(self%load(j - 1), self%size(j - 1), 0.0_wp)
         shell%outer = edge_type(self%load(j), self%size(j), 0.0_wp)
         shell%stiffness = stiffness*springs*fading
         shell%trial = trial*lengths/fading
         call slip_of_shell(shell, course%off, shared, bearing, towards, self%slipped(j), done)
         if (follows) call course%note(place, before, towards)
         do i = 1, 3
            self%direction(j, i) = towards(i)
         end do
         last = towards
         if (.not. self%slipped(j)) cycle
         if (present(slopes)) call add_slopes(self, j, new, spot, trial, bearing, towards, slopes)
         do i = 1, 3
            self%shift(j, i) = bearing(i)*units(i)/max(stiffness(i), tiny(stiffness))
         end do
         work = work + done
      end do
   end subroutine let_slip

   !> Let some of the shells of a circle slip, side by side. Those whose slip is not found soon, or
   !> not by this way, are left to `let_slip`; the excess of all others is below zero then.
   pure subroutine let_slip_on_circle(self, new, spot, step, work, slopes)
      !> The shells, after their elastic trials.
      class(shells_type), intent(inout) :: self
      !> The number of the shells at the rim that are new.
      integer, intent(in) :: new
      type(spring_spot_type), intent(in) :: spot
      !> As of `advance`.
      real(wp), intent(in) :: step(3)
      !> Work of the slip over the limit, added to.
      real(wp), intent(inout) :: work
      !> Derivatives of the wrench, added to.
      real(wp), intent(inout), optional :: slopes(3, 4)
      real(wp), dimension(lanes, 2) :: stiffness, plane, trial, held, u, force
      real(wp) :: springs(lanes, 3), part
      real(wp), dimension(lanes, 2) :: load, size
      real(wp) :: shift(lanes, 3), direction(lanes, 3), length(lanes), done(lanes), &
         per_limit, across, along, spinning, inverse, lever
      logical :: found(lanes), steady
      integer :: at(lanes), i, j, n, last

      per_limit = 1.0_wp/spot%limit
      inverse = self%fading/spot%a
      lever = spot%a/self%fading
      last = self%n
      do while (last > 0)
         call gather(self%excess, self%load, self%size, self%share, self%shift, &
            self%direction, last, n, at, load, size, springs, shift, direction)
         if (n == 0) exit
         do i = 1, n
            stiffness(i, 1) = springs(i, 2)*per_limit
            stiffness(i, 2) = springs(i, 3)*per_limit*inverse/spot%a
            across = sqrt(shift(i, 1)**2 + shift(i, 2)**2)
            along = 1.0_wp/max(across, tiny(across))
            plane(i, 1) = shift(i, 1)*along
            plane(i, 2) = shift(i, 2)*along
            trial(i, 1) = stiffness(i, 1)*across
            trial(i, 2) = stiffness(i, 2)*abs(shift(i, 3))*lever
            along = direction(i, 1)*plane(i, 1) + direction(i, 2)*plane(i, 2)
            spinning = direction(i, 3)*sign(1.0_wp, shift(i, 3))
            length(i) = min(along, spinning)
            ! Else between those of an infinitely short and an infinitely long slip.
            u(i, 1) = merge(along, trial(i, 1)*(load(i, 1)*size(i, 1) - load(i, 2)*size(i, 2))**2, &
               length(i) > 0.0_wp)
            u(i, 2) = merge(spinning, trial(i, 2)*(load(i, 1) - load(i, 2))**2, length(i) > 0.0_wp)
            along = 1.0_wp/sqrt(max(u(i, 1)**2 + u(i, 2)**2, tiny(along)))
            u(i, 1) = u(i, 1)*along
            u(i, 2) = u(i, 2)*along
         end do
         steady = all(length(:n) > 0.0_wp)
         if (.not. steady) then
            do i = 1, n
               held(i, 1) = 0.0_wp
               held(i, 2) = 0.0_wp
               if (.not. (self%slid(at(i)) > 0.5_wp .and. length(i) > 0.0_wp)) cycle
               part = part_of_step(at(i), self%n, new)
               held(i, 1) = trial(i, 1) - stiffness(i, 1)*(part*(step(1)*plane(i, 1) &
                  + step(2)*plane(i, 2)))
               held(i, 2) = trial(i, 2) - stiffness(i, 2)*(part*sign(step(3)*lever, &
                  step(3)*shift(i, 3)))
            end do
         end if
         call self%kernels%slip_on_circles(spot%shape%torque, n, load, size, stiffness, trial, &
            held, steady, u, force, found)
         do i = 1, n
            length(i) = (trial(i, 1) - force(i, 1))*u(i, 1) + (trial(i, 2) - force(i, 2))*u(i, 2)
            done(i) = (force(i, 1)*u(i, 1) + force(i, 2)*u(i, 2))*length(i) &
               /(stiffness(i, 1)*u(i, 1)**2 + stiffness(i, 2)*u(i, 2)**2)
         end do
         call scatter(n, at, found, length, u, plane, force, stiffness, inverse, self%excess, &
            self%slipped, self%shift, self%direction)
         do i = 1, n
            if (found(i) .and. length(i) > 0.0_wp) work = work + done(i)
         end do
         if (present(slopes)) then
            do i = 1, n
               j = at(i)
               if (.not. (found(i) .and. self%slipped(j))) cycle
               call add_slopes(self, j, new, spot, shift(i, :), [force(i, 1)*plane(i, :), &
                  sign(force(i, 2), shift(i, 3))], self%direction(j, :), slopes)
            end do
         end if
      end do
   end subroutine let_slip_on_circle

   !> Note the slips of shells of a circle.
   pure subroutine scatter(n, at, found, length, u, plane, force, stiffness, per_size, excess, &
      slipped, shift, direction)
      !> Number of the shells, and which they are.
      integer, intent(in) :: n, at(lanes)
      !> Whether it is known how they slip.
      logical, intent(in) :: found(lanes)
      !> > 0 if they do.
      real(wp), intent(in) :: length(lanes)
      !> Sliding and spinning, the direction of sliding, and the force.
      real(wp), intent(in), dimension(lanes, 2) :: u, plane, force, stiffness
      !> What is left of slip about the normal, over the semi-axis [1/m].
      real(wp), intent(in) :: per_size
      !> As of `shells_type`.
      real(wp), intent(inout), contiguous :: excess(:)
      logical, intent(inout), contiguous :: slipped(:)
      real(wp), intent(inout), contiguous :: shift(:, :), direction(:, :)
      real(wp) :: along
      integer :: i, j

      do i = 1, n
         if (.not. found(i)) cycle
         j = at(i)
         excess(j) = -1.0_wp
         if (.not. length(i) > 0.0_wp) cycle
         slipped(j) = .true.
         direction(j, 1) = u(i, 1)*plane(i, 1)
         direction(j, 2) = u(i, 1)*plane(i, 2)
         direction(j, 3) = sign(u(i, 2), shift(j, 3))
         along = force(i, 1)/stiffness(i, 1)
         shift(j, 1) = along*plane(i, 1)
         shift(j, 2) = along*plane(i, 2)
         shift(j, 3) = sign(force(i, 2)*per_size/stiffness(i, 2), shift(j, 3))
      end do
   end subroutine scatter

   !> The shells of a circle that may slip and are shifted and twisted, side by side.
   pure subroutine gather(excess, load, size, share, shift, direction, last, n, &
      at, loads, sizes, stiffness, shifts, directions)
      !> As of `shells_type`.
      real(wp), intent(in), contiguous :: excess(:), load(0:), size(0:)
      real(wp), intent(in), contiguous :: share(:, :), shift(:, :), direction(:, :)
      !> The shell to begin with, from which it goes inwards; that of the next time.
      integer, intent(inout) :: last
      !> Number of those that may slip, and which they are.
      integer, intent(out) :: n, at(lanes)
      !> Of their outer and inner edges.
      real(wp), intent(inout) :: loads(lanes, 2), sizes(lanes, 2)
      real(wp), intent(inout), dimension(lanes, 3) :: stiffness, shifts, directions
      integer :: j

      n = 0
      do j = last, 1, -1
         if (excess(j) < 0.0_wp) cycle
         if (.not. (load(j) > load(j - 1) .and. share(j, 1) > 0.0_wp .and. share(j, 2) > 0.0_wp &
            .and. share(j, 3) > 0.0_wp .and. abs(shift(j, 3)) > 0.0_wp)) cycle
         if (abs(share(j, 1) - share(j, 2)) > 0.0_wp) cycle
         if (.not. abs(shift(j, 1)) + abs(shift(j, 2)) > 0.0_wp) cycle
         n = n + 1
         at(n) = j
         loads(n, 1) = load(j)
         loads(n, 2) = load(j - 1)
         sizes(n, 1) = size(j)
         sizes(n, 2) = size(j - 1)
         stiffness(n, 1) = share(j, 1)
         stiffness(n, 2) = share(j, 2)
         stiffness(n, 3) = share(j, 3)
         shifts(n, 1) = shift(j, 1)
         shifts(n, 2) = shift(j, 2)
         shifts(n, 3) = shift(j, 3)
         directions(n, 1) = direction(j, 1)
         directions(n, 2) = direction(j, 2)
         directions(n, 3) = direction(j, 3)
         if (n == lanes) exit
      end do
      last = j - 1
   end subroutine gather

   !> Let shells of an ellipse slip, as `let_slip_on_circle` does.
   pure subroutine let_slip_on_ellipse(self, new, spot, step, way, work, slopes)
      !> The shells, after their elastic trials.
      class(shells_type), intent(inout) :: self
      !> The number of the shells at the rim that are new.
      integer, intent(in) :: new
      type(spring_spot_type), intent(in) :: spot
      !> As of `advance`.
      real(wp), intent(in) :: step(3)
      !> Way of the step, as that of `nest_type`.
      real(wp), intent(in) :: way
      !> Work of the slip over the limit, added to.
      real(wp), intent(inout) :: work
      !> Derivatives of the wrench, added to.
      real(wp), intent(inout), optional :: slopes(3, 4)
      real(wp), dimension(lanes, 3) :: stiffness, trial, held, u, force, elastic
      real(wp), dimension(lanes, 2) :: load, size
      real(wp), dimension(lanes) :: asked, length, done
      real(wp) :: along(3), turn(3), scaled(3)
      logical :: found(lanes), steady
      integer :: inside, outermost, n, i, j

      scaled = [step(1), step(2), step(3)*spot%a/self%fading]
      along = scaled*(1.0_wp/max(sqrt(dot_product(scaled, scaled)), tiny(along)))
      turn = along - self%went
      self%went = along
      call self%ellipse%set_ratio(spot%shape%k, spot%shape%k2, spot%shape%c)
      outermost = self%n
      do while (outermost > 0)
         if (self%excess(outermost) < 0.0_wp .or. self%load(outermost) - self%load(outermost - 1) &
            < narrow_load) then
            outermost = outermost - 1
            cycle
         end if
         inside = max(outermost - lanes, 0)
         n = outermost - inside
         steady = way < long_step .and. all(abs(turn) < little)
         call self%kernels%lay_out(self%shell_data_type, inside, n, spot%limit, scaled, along, &
            turn, asked, load, size, stiffness, trial, held, steady, u)
         call self%kernels%slip_on_ellipses(self%ellipse, spot%shape%torque, asked, load, size, &
            stiffness, trial, held, steady, u, force, elastic, length, done, found)
         if (present(slopes)) then
            do i = 1, n
               j = inside + i
               if (found(i) .and. length(i) > 0.0_wp) call add_slopes(self, j, new, spot, &
                  self%shift(j, :), force(i, :), u(i, :), slopes)
            end do
         end if
         call self%kernels%take_back(self%shell_data_type, inside, u, elastic, length, done, &
            found, work)
         outermost = inside
      end do
   end subroutine let_slip_on_ellipse

   !> Let what is new at the rim of an ellipse, and bears next to nothing, slip in the direction of
   !> the shell inside of it, if that slips. What is lost is the work of the force along the slip,
   !> so that none returns more than it took.
   pure subroutine let_rim_follow(self, spot, work)
      !> The shells, after `let_slip_on_ellipse`.
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Work of the slip over the limit, added to.
      real(wp), intent(inout) :: work
      real(wp) :: force(lanes, 3), units(3), trial(3), done
      integer :: i, j, n, inside

      do inside = self%n, 1, -1
         if (self%load(inside) - self%load(inside - 1) >= least_own_load) exit
      end do
      n = min(self%n - inside, lanes)
      if (n == 0 .or. inside == 0) return
      if (.not. self%slipped(inside)) return
      call self%kernels%slide_shells(self%ellipse, n, self%load(inside), self%size(inside), &
         self%direction(inside, :), force)
      units = spot%limit*[1.0_wp, 1.0_wp, spot%a]
      do i = 1, n
         j = inside + i
         if (self%excess(j) < 0.0_wp .or. .not. minval(self%share(j, :)) > 0.0_wp) cycle
         trial = self%shift(j, :)
         force(i, :) = force(i, :)*units/self%share(j, :)
         done = sum(self%share(j, :)*force(i, :)*(trial - force(i, :)))
         if (.not. done > 0.0_wp) cycle
         self%excess(j) = -1.0_wp
         self%slipped(j) = .true.
         self%direction(j, :) = self%direction(inside, :)
         self%shift(j, :) = force(i, :)
         work = work + done/spot%limit
      end do
   end subroutine let_rim_follow

   !> Let some of the shells slip where nothing is twisted, and none depends on another.
   pure subroutine let_slip_in_plane(self, from, to, new, spot, work, slopes)
      !> The shells, after their elastic trials.
      class(shells_type), intent(inout) :: self
      !> The first and the last of them, and the number of the shells at the rim that are new.
      integer, intent(in) :: from, to, new
      type(spring_spot_type), intent(in) :: spot
      !> Work of the slip over the limit, added to.
      real(wp), intent(inout) :: work
      !> Derivatives of the wrench, added to.
      real(wp), intent(inout), optional :: slopes(3, 4)
      real(wp), dimension(abreast, 2) :: stiffness, trial, force, direction
      real(wp) :: load(abreast), done(abreast), per_limit
      integer :: at(abreast), i, j, n

      per_limit = 1.0_wp/spot%limit
      n = 0
      do j = to, from, -1
         if (self%excess(j) < 0.0_wp) cycle
         i = n + 1
         at(i) = j
         load(i) = self%load(j) - self%load(j - 1)
         stiffness(i, 1) = self%share(j, 1)*per_limit
         stiffness(i, 2) = self%share(j, 2)*per_limit
         trial(i, 1) = self%shift(j, 1)
         trial(i, 2) = self%shift(j, 2)
         force(i, 1) = stiffness(i, 1)*trial(i, 1)
         force(i, 2) = stiffness(i, 2)*trial(i, 2)
         if (.not. min(load(i), stiffness(i, 1), stiffness(i, 2)) > 0.0_wp) then
            ! So narrow that rounding errors leave nothing of it.
            self%slipped(j) = .true.
            self%shift(j, :) = 0.0_wp
         else if (force(i, 1)**2 + force(i, 2)**2 > load(i)**2) then
            n = i
         end if
      end do
      call self%kernels%slip_in_plane(n, load, stiffness, trial, force, direction, done)
      do i = 1, n
         j = at(i)
         self%slipped(j) = .true.
         if (present(slopes)) call add_slopes(self, j, new, spot, [trial(i, :), 0.0_wp], &
            [force(i, :), 0.0_wp], [direction(i, :), 0.0_wp], slopes)
         self%shift(j, 1) = force(i, 1)/stiffness(i, 1)
         self%shift(j, 2) = force(i, 2)/stiffness(i, 2)
         self%direction(j, 1) = direction(i, 1)
         self%direction(j, 2) = direction(i, 2)
         self%direction(j, 3) = 0.0_wp
         work = work + done(i)
      end do
   end subroutine let_slip_in_plane

   !> Add what shells that stick contribute to the derivatives of the wrench.
   pure subroutine add_springs(self, new, slopes)
      class(shells_type), intent(in) :: self
      !> Number of the shells at the rim that are new.
      integer, intent(in) :: new
      real(wp), intent(inout) :: slopes(3, 4)
      integer :: i, j

      do j = 1, self%n
         if (self%slipped(j)) cycle
         do i = 1, 3
            slopes(i, i) = slopes(i, i) - part_of_step(j, self%n, new)*self%share(j, i)
         end do
      end do
   end subroutine add_springs

   !> Guess the direction of the slip of a shell.
   pure subroutine foresee(self, place, before, direction)
      class(course_type), intent(inout) :: self
      !> Place of the shell in any unit.
      real(wp), intent(in) :: place
      !> Direction in the step before, or zero.
      real(wp), intent(in) :: before(3)
      real(wp), intent(out) :: direction(3)
      real(wp) :: ahead, apart, part
      integer :: i

      self%guess(:, 1) = before
      self%guess(:, 2) = before
      if (self%known > 0) then
         part = 0.0_wp
         if (self%known > 1) then
            ahead = self%place(1) - place
            apart = self%place(2) - self%place(1)
            ! Not from shells that are narrow by far.
            if (ahead < farthest_guess*apart) part = ahead/apart
         end if
         do i = 1, 3
            self%guess(i, 1) = before(i) + (self%change(i, 1) + part*(self%change(i, 1) &
               - self%change(i, 2)))
            self%guess(i, 2) = self%direction(i, 1) + part*(self%direction(i, 1) &
               - self%direction(i, 2))
         end do
         if (abs(before(3)) <= 0.0_wp) self%guess(:, 1) = self%direction(:, 1)
      end if
      direction = self%guess(:, self%better)
   end subroutine foresee

   !> Take note of the direction of the slip of a shell.
   pure subroutine note(self, place, before, direction)
      class(course_type), intent(inout) :: self
      !> Place of the shell in any unit.
      real(wp), intent(in) :: place
      !> Direction in the step before, or zero, and now.
      real(wp), intent(in) :: before(3), direction(3)
      real(wp) :: off1, off2, same
      integer :: i

      off1 = 0.0_wp
      off2 = 0.0_wp
      ! Without a slip with a twist before there is no change.
      same = merge(0.0_wp, 1.0_wp, abs(before(3)) <= 0.0_wp)
      do i = 1, 3
         off1 = off1 + (self%guess(i, 1) - direction(i))**2
         off2 = off2 + (self%guess(i, 2) - direction(i))**2
         self%change(i, 2) = self%change(i, 1)
         self%change(i, 1) = same*(direction(i) - before(i))
         self%direction(i, 2) = self%direction(i, 1)
         self%direction(i, 1) = direction(i)
      end do
      self%better = merge(2, 1, off2 < off1)
      self%off = sqrt(min(off1, off2))
      self%place(2) = self%place(1)
      self%place(1) = place
      self%known = min(self%known + 1, 2)
   end subroutine note

   !> Add what a shell that slips contributes to the derivatives of the wrench.
   pure subroutine add_slopes(self, j, new, spot, trial, bearing, direction, slopes)
      class(shells_type), intent(in) :: self
      !> The shell, and the number of those at the rim that are new.
      integer, intent(in) :: j, new
      type(spring_spot_type), intent(in) :: spot
      !> Elastic displacement of the trial.
      real(wp), intent(in) :: trial(3)
      !> Force of the shell in its units.
      real(wp), intent(in) :: bearing(3)
      !> Direction of its slip.
      real(wp), intent(in) :: direction(3)
      real(wp), intent(inout) :: slopes(3, 4)
      type(shell_type) :: shell
      real(wp) :: units(3), k(3), fading(3), slip(3), length, part, by_trial(3, 3), by_limit(3)
      integer :: i

      shell%shape = spot%shape
      shell%rung => spot%rung
      shell%inner = edge_type(self%load(j - 1), self%size(j - 1), 0.0_wp)
      shell%outer = edge_type(self%load(j), self%size(j), 0.0_wp)
      units = spot%limit*[1.0_wp, 1.0_wp, spot%a]
      fading = [1.0_wp, 1.0_wp, self%fading]
      k = self%share(j, :)*(spot%limit/units**2)*fading
      if (.not. minval(k) > 0.0_wp) return
      ! So narrow that it bears nothing, where nothing has moved.
      if (.not. any(abs(direction) > 0.0_wp)) return
      if (shell%load() < least_load) return
      slip = trial*(units/spot%limit)/fading - bearing/k
      length = max(norm2(slip), shortest_slip*norm2(bearing/k))
      shell%stiffness = k
      call stiffness_after(shell, direction, length, by_trial, by_limit)
      part = part_of_step(j, self%n, new)
      do i = 1, 3
         slopes(:, i) = slopes(:, i) - part*by_trial(:, i)*units*units(i)/(spot%limit*fading(i))
      end do
      slopes(:, 4) = slopes(:, 4) - by_limit*units/spot%limit
   end subroutine add_slopes

   !> Bear what sliding gives.
   pure subroutine slide(self, spot, velocity, share)
      class(shells_type), intent(inout) :: self
      type(spring_spot_type), intent(in) :: spot
      !> Sliding velocity along the axes [m/s] and spin [rad/s].
      real(wp), intent(in) :: velocity(3)
      !> Share of that, the rest is as it was.
      real(wp), intent(in) :: share
      real(wp) :: u(3), force(3), stiffness(3), hessian(3, 3), size
      type(shared_type) :: shared
      type(shell_type) :: shell
      logical :: bears(3)
      integer :: j

      u = velocity*[1.0_wp, 1.0_wp, spot%a]
      size = sqrt(dot_product(u, u))
      if (.not. size > 0.0_wp) return
      u = u/size
      shell%shape = spot%shape
      shell%rung => spot%rung
      do j = self%n, 1, -1
         stiffness = self%share(j, :)
         shell%inner = self%within(j - 1)
         shell%outer = self%within(j)
         call sliding_force(shell, u, shared, force, hessian)
         force = force*spot%limit*[1.0_wp, 1.0_wp, spot%a]
         ! A shell so narrow that rounding leaves it no stiffness bears nothing.
         bears = stiffness > epsilon(stiffness)**2*spot%stiffness
         force = merge(force, 0.0_wp, bears)/merge(stiffness, 1.0_wp, bears)
         self%shift(j, :) = (1.0_wp - share)*self%shift(j, :) + share*force
         self%uneven(j) = (1.0_wp - share)*self%uneven(j)
         self%direction(j, :) = u
         self%slipped(j) = .true.
      end do
   end subroutine slide

end module contensou_contact_tangential_shells
