!> What a result file tells of its ball bearings: means over the end of the run of loads, angles,
!> pivoting and losses by ball and race.
!>
!> A bearing is known by the names that `&bearing` gives: bodies NAME_ball_I, contacts NAME_inner_I
!> and NAME_outer_I, or NAME_inner_upper_I ... with two arcs, and NAME_pocket_I. Which bodies carry
!> the grooves follows from the surfaces of the contacts. Means are weighted by time.
module contensou_files_bearing_run
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_document, only : document_type, parse_document, value_integer, value_real
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_text, only : lower, string_type
   use contensou_base_vectors, only : cross
   use contensou_files_hdf5_reader, only : class_real, class_text, hdf5_item_type, &
      hdf5_reader_type, probe
   use contensou_study_race_losses, only : race_spot_type
   implicit none(type, external)
   private

   public :: bearing_run_type, race_type, run_losses_type, read_bearings

   !> What the contacts of the balls with a ring say, by ball and arc.
   type :: race_type
      !> Loads [N], contact angles [rad] - positive where the inner ring is displaced along the
      !> axis -, largest pressures [Pa], ratios of spin to roll; angles and ratios are means of the
      !> time in which a contact is loaded, and NaN without any.
      real(wp), allocatable :: load(:, :), angle(:, :), stress(:, :), pivoting(:, :)
      !> Semi-axes of the spots [m], angular velocity of the ball against the ring in the plane of
      !> the spot, and about its normal [rad/s].
      real(wp), allocatable :: major(:, :), minor(:, :), rolling(:, :), spin(:, :)
      !> Friction coefficients.
      real(wp), allocatable :: friction(:, :)
      !> Power lost by pivoting, sliding and curvature [W].
      real(wp) :: loss(3) = 0.0_wp
      !> Angular velocity of the ring about the axis [rad/s].
      real(wp) :: speed = 0.0_wp
      !> Radii of the groove and of the circle of its centres [m].
      real(wp) :: groove = 0.0_wp, circle = 0.0_wp
      !> Body, and contacts by ball and arc.
      integer, private :: body = 0
      integer, allocatable, private :: contacts(:, :)
      !> Centre and axis of the groove in the frame of its body.
      real(wp), private :: centre(3) = 0.0_wp, axis(3) = 0.0_wp
   end type race_type

   !> A bearing whose loads a run has written.
   type :: bearing_run_type
      character(len=:), allocatable :: name
      integer :: balls = 0
      !> Arcs of each groove, 1 or 2.
      integer :: arcs = 1
      !> Inner and outer race.
      type(race_type) :: races(2)
      !> Radius of a ball and of the circle of the balls [m].
      real(wp) :: radius = 0.0_wp, pitch = 0.0_wp
      !> Angular velocity of the balls about the axis, and of the cage [rad/s].
      real(wp) :: orbit = 0.0_wp, cage = 0.0_wp
      logical :: has_cage = .false.
      !> Power lost in the pockets of the cage [W].
      real(wp) :: cage_loss = 0.0_wp
      !> Nominal contact angle [rad]: of the key, or 0.
      real(wp) :: nominal = 0.0_wp
      integer, allocatable, private :: ball_bodies(:), pockets(:)
      integer, private :: cage_body = 0
   contains
      procedure :: spot
      procedure :: mean_angle
      procedure :: epicyclic
   end type bearing_run_type

   !> What is lost in the whole scene [W].
   type :: run_losses_type
      real(wp) :: friction = 0.0_wp, damping = 0.0_wp
      !> From when to when [s].
      real(wp) :: from = 0.0_wp, until = 0.0_wp
      !> Number of contacts, and of those that belong to bearings.
      integer :: contacts = 0, of_bearings = 0
      !> Whether springs of the scene have a share in the damping.
      logical :: dashpots = .false.
   end type run_losses_type

   !> Columns of the trajectory, the values of a row beside each other.
   type :: column_type
      character(len=16) :: name = ""
      type(hdf5_item_type) :: item
      integer(i8) :: width = 0_i8
      real(wp), allocatable :: values(:, :)
   end type column_type

   integer, parameter :: c_force = 1, c_spin = 2, c_normal = 3, c_axes = 4, c_torque = 5, &
      c_friction = 6, c_slip = 7, c_turning = 8, c_position = 9, c_velocity = 10, &
      c_attitude = 11, c_moment = 12
   character(len=16), parameter :: names(12) = [character(len=16) :: "normal_force", "spin", &
      "contact_normal", "semi_axes", "friction_torque", "friction_force", "slip_velocity", &
      "angular_velocity", "position", "velocity", "quaternion", "spot_moment"]

   !> Values of a column that are read at a time.
   integer(i8), parameter :: block_values = 262144_i8

   !> Names of the rings and of the arcs in those of contacts.
   character(len=*), parameter :: rings(2) = ["inner", "outer"], arcs(2) = ["_upper", "_lower"]

contains

   !> Read the bearings of a file.
   subroutine read_bearings(path, part, bearings, losses, error)
      character(len=*), intent(in) :: path
      !> Part of the run that counts, its end, in (0, 1].
      real(wp), intent(in) :: part
      type(bearing_run_type), allocatable, intent(out) :: bearings(:)
      type(run_losses_type), intent(out) :: losses
      !> Set when the file cannot be read or has no bearing.
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_reader_type) :: reader

      call probe(path, error)
      if (.not. allocated(error)) call reader%open(path, error)
      if (allocated(error)) return
      call find_bearings(reader, path, bearings, losses, error)
      if (.not. allocated(error)) call read_settings(reader, bearings, losses, error)
      if (.not. allocated(error)) call average(reader, path, part, bearings, losses, error)
      call reader%close()
   end subroutine read_bearings

   !> Find the bearings by the names of their parts.
   subroutine find_bearings(reader, path, bearings, losses, error)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: path
      type(bearing_run_type), allocatable, intent(out) :: bearings(:)
      type(run_losses_type), intent(inout) :: losses
      type(error_type), allocatable, intent(out) :: error
      character(len=*), parameter :: first = "_ball_1"
      type(string_type), allocatable :: bodies(:), contacts(:), pairs(:), surfaces(:), carriers(:)
      real(wp), allocatable :: minor(:), major(:), radius(:), centres(:), axes(:)
      integer :: i, k, n

      call texts(reader, "/body/name", bodies, error)
      if (.not. allocated(error)) call texts(reader, "/contact/name", contacts, error)
      if (.not. allocated(error)) call texts(reader, "/contact/surfaces", pairs, error)
      if (.not. allocated(error)) call texts(reader, "/surface/name", surfaces, error)
      if (.not. allocated(error)) call texts(reader, "/surface/body", carriers, error)
      if (.not. allocated(error)) call reals(reader, "/surface/minor_radius", minor, error)
      if (.not. allocated(error)) call reals(reader, "/surface/major_radius", major, error)
      if (.not. allocated(error)) call reals(reader, "/surface/radius", radius, error)
      if (.not. allocated(error)) call reals(reader, "/surface/centre", centres, error)
      if (.not. allocated(error)) call reals(reader, "/surface/axes", axes, error)
      if (allocated(error)) then
         deallocate(error)
         n = 0
      else
         n = count([(is_first(i), i=1, size(bodies))])
      end if
      if (n == 0) then
         call fatal(error, path // " is no run of a scene with a group &bearing", status_usage)
         return
      end if
      losses%contacts = size(contacts)
      allocate(bearings(n))
      n = 0
      do i = 1, size(bodies)
         if (.not. is_first(i)) cycle
         n = n + 1
         associate (name => bodies(i)%s(:len(bodies(i)%s) - len(first)))
            call fill(bearings(n), name)
         end associate
      end do

   contains

      !> Whether a body is the first ball of a bearing.
      logical function is_first(body)
         integer, intent(in) :: body

         associate (name => bodies(body)%s)
            is_first = .false.
            if (len(name) <= len(first)) return
            if (name(len(name) - len(first) + 1:) /= first) return
            associate (stem => name(:len(name) - len(first)))
               is_first = place(contacts, stem // "_inner_1") > 0 .or. &
                  place(contacts, stem // "_inner" // arcs(1) // "_1") > 0
            end associate
         end associate
      end function is_first

      !> Fill in a bearing.
      subroutine fill(bearing, stem)
         type(bearing_run_type), intent(inout) :: bearing
         character(len=*), intent(in) :: stem
         integer :: a, b, s
         character(len=:), allocatable :: arc

         bearing%name = stem
         do
            b = place(bodies, stem // "_ball_" // to_text(bearing%balls + 1))
            if (b == 0) exit
            bearing%balls = bearing%balls + 1
         end do
         if (place(contacts, stem // "_inner_1") == 0) bearing%arcs = 2
         allocate(bearing%ball_bodies(bearing%balls), bearing%pockets(bearing%balls))
         do b = 1, bearing%balls
            bearing%ball_bodies(b) = place(bodies, stem // "_ball_" // to_text(b))
            bearing%pockets(b) = place(contacts, stem // "_pocket_" // to_text(b))
         end do
         bearing%cage_body = place(bodies, stem // "_cage")
         bearing%has_cage = bearing%cage_body > 0 .and. bearing%pockets(1) > 0
         bearing%radius = radius(place(surfaces, stem // "_ball_1"))
         do k = 1, 2
            associate (race => bearing%races(k))
               allocate(race%contacts(bearing%balls, bearing%arcs))
               do a = 1, bearing%arcs
                  arc = ""
                  if (bearing%arcs == 2) arc = arcs(a)
                  do b = 1, bearing%balls
                     race%contacts(b, a) = place(contacts, stem // "_" // rings(k) // arc // &
                        "_" // to_text(b))
                  end do
               end do
               if (any(race%contacts == 0)) then
                  call fatal(error, path // " lacks contacts of bearing '" // stem // "'", &
                     status_usage)
                  return
               end if
               s = place(surfaces, pairs(2*race%contacts(1, 1) - 1)%s)
               race%body = place(bodies, carriers(s)%s)
               race%groove = minor(s)
               race%circle = major(s)
               race%centre = centres(3*s - 2:3*s)
               race%axis = axes(9*s - 2:9*s)
               losses%of_bearings = losses%of_bearings + size(race%contacts)
            end associate
         end do
         if (bearing%has_cage) losses%of_bearings = losses%of_bearings + bearing%balls
      end subroutine fill

   end subroutine find_bearings

   !> Read what the texts of the scene say: friction coefficients, nominal contact angles.
   subroutine read_settings(reader, bearings, losses, error)
      type(hdf5_reader_type), intent(in) :: reader
      type(bearing_run_type), intent(inout) :: bearings(:)
      type(run_losses_type), intent(inout) :: losses
      type(error_type), allocatable, intent(out) :: error
      type(string_type), allocatable :: contacts(:)
      type(document_type) :: document
      type(diagnostics_type) :: diagnostics
      character(len=:), allocatable :: text
      real(wp), allocatable :: friction(:)
      real(wp) :: value
      integer :: i, k, m

      call texts(reader, "/contact/name", contacts, error)
      if (.not. allocated(error)) call reader%read_text("/input/resolved", "", text, error)
      if (allocated(error)) return
      call parse_document("resolved", text, document, diagnostics)
      allocate(friction(size(contacts)))
      friction = 0.0_wp
      m = 0
      do i = 1, document%n_groups
         if (document%groups(i)%name == "spring") losses%dashpots = losses%dashpots .or. &
            document%groups(i)%gives("damping") .or. &
            document%groups(i)%gives("rotational_damping")
         if (document%groups(i)%name /= "contact") cycle
         m = m + 1
         if (m > size(friction)) exit
         if (number("friction_coefficient")) friction(m) = value
      end do
      do i = 1, size(bearings)
         do k = 1, 2
            associate (race => bearings(i)%races(k))
               race%friction = reshape(friction([race%contacts]), shape(race%contacts))
            end associate
         end do
      end do
      call reader%read_text("/input/namelist", "", text, error)
      if (allocated(error)) return
      call parse_document("scene", text, document, diagnostics)
      do i = 1, document%n_groups
         if (document%groups(i)%name /= "bearing") cycle
         do k = 1, size(bearings)
            if (label() /= lower(bearings(k)%name)) cycle
            associate (races => bearings(k)%races, play => sum(bearings(k)%races%groove) &
               - 2.0_wp*bearings(k)%radius)
               ! As it was built, whatever --set made of the key.
               if (document%groups(i)%gives("contact_angle")) bearings(k)%nominal = &
                  acos(min((races(1)%circle - races(2)%circle)/play, 1.0_wp))
            end associate
         end do
      end do

   contains

      !> Whether a group gives a number to a key, which is then `value`.
      logical function number(key)
         character(len=*), intent(in) :: key
         integer :: j

         number = .false.
         do j = 1, document%groups(i)%n_assignments
            associate (assignment => document%groups(i)%assignments(j))
               if (assignment%key /= key .or. size(assignment%values) == 0) cycle
               number = any(assignment%values(1)%kind == [value_integer, value_real])
               if (number) value = assignment%values(1)%real
            end associate
         end do
      end function number

      !> Name that a group has, in lower case.
      function label() result(name)
         character(len=:), allocatable :: name
         integer :: j

         name = ""
         do j = 1, document%groups(i)%n_assignments
            associate (assignment => document%groups(i)%assignments(j))
               if (assignment%key /= "name" .or. size(assignment%values) == 0) cycle
               if (allocated(assignment%values(1)%text)) name = lower(assignment%values(1)%text)
            end associate
         end do
      end function label

   end subroutine read_settings

   !> Take the means.
   subroutine average(reader, path, part, bearings, losses, error)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: path
      real(wp), intent(in) :: part
      type(bearing_run_type), intent(inout) :: bearings(:)
      type(run_losses_type), intent(inout) :: losses
      type(error_type), allocatable, intent(out) :: error
      type(column_type) :: columns(size(names))
      real(wp), allocatable :: time(:), weights(:), work(:)
      integer(i8) :: first, last, row, n
      integer :: i, c

      call reals(reader, "/trajectory/time", time, error)
      if (allocated(error)) return
      if (size(time) == 0) then
         call fatal(error, path // " has no rows", status_usage)
         return
      end if
      last = size(time, kind=i8)
      first = min(int((1.0_wp - part)*last, i8), last - 1) + 1
      losses%from = time(first)
      losses%until = time(last)
      allocate(weights(size(time)))
      weights = 0.0_wp
      if (last > first) then
         weights(first:last - 1) = 0.5_wp*(time(first + 1:last) - time(first:last - 1))
         weights(first + 1:last) = weights(first + 1:last) + 0.5_wp*(time(first + 1:last) &
            - time(first:last - 1))
         weights = weights/max(time(last) - time(first), tiny(time))
         call reals(reader, "/trajectory/work_friction", work, error)
         if (.not. allocated(error)) losses%friction = (work(last) - work(first)) &
            /(time(last) - time(first))
         if (.not. allocated(error)) call reals(reader, "/trajectory/work_damping", work, error)
         if (.not. allocated(error)) losses%damping = (work(last) - work(first)) &
            /(time(last) - time(first))
         if (allocated(error)) return
      else
         weights(first) = 1.0_wp
      end if
      do i = 1, size(bearings)
         call begin(bearings(i))
      end do
      do c = 1, size(names)
         columns(c)%name = names(c)
         call reader%open_item("/trajectory/" // trim(names(c)), "", columns(c)%item, error)
         if (allocated(error) .and. c == c_moment) then
            ! All spots are flat.
            deallocate(error)
            cycle
         end if
         if (allocated(error)) then
            call fatal(error, path // " has no " // trim(names(c)) // "; contact_geometry = " // &
               ".true. in &output writes what is needed", status_usage)
            exit
         end if
         associate (item => columns(c)%item)
            columns(c)%width = product(item%extents(2:item%rank))
         end associate
      end do
      row = first
      do while (row <= last .and. .not. allocated(error))
         n = min(last - row + 1, max(block_values/max(maxval(columns%width), 1_i8), 1_i8))
         do c = 1, size(columns)
            if (.not. columns(c)%item%is_open()) cycle
            if (allocated(columns(c)%values)) deallocate(columns(c)%values)
            allocate(columns(c)%values(columns(c)%width, n))
            associate (extents => columns(c)%item%extents)
               call columns(c)%item%read([row - 1, 0_i8, 0_i8], [n, max(extents(2), 1_i8), &
                  max(extents(3), 1_i8)], columns(c)%values, error)
            end associate
            if (allocated(error)) exit
            if (.not. all(ieee_is_finite(columns(c)%values))) then
               call fatal(error, path // " is damaged: /trajectory/" // trim(names(c)) // &
                  " has values that are no numbers", status_file)
               exit
            end if
         end do
         if (allocated(error)) exit
         do i = 1, size(bearings)
            call add_rows(bearings(i), columns, weights(row:row + n - 1))
         end do
         row = row + n
      end do
      do c = 1, size(columns)
         call columns(c)%item%close()
      end do
      do i = 1, size(bearings)
         call finish(bearings(i))
      end do
   end subroutine average

   !> Set all means to zero.
   subroutine begin(bearing)
      type(bearing_run_type), intent(inout) :: bearing
      integer :: k

      do k = 1, 2
         associate (race => bearing%races(k))
            allocate(race%load(bearing%balls, bearing%arcs), source=0.0_wp)
            race%angle = race%load
            race%stress = race%load
            race%pivoting = race%load
            race%major = race%load
            race%minor = race%load
            race%rolling = race%load
            race%spin = race%load
         end associate
      end do
   end subroutine begin

   !> Add rows to the means. Angles, sizes and velocities are weighted by the load, too.
   subroutine add_rows(bearing, columns, weights)
      type(bearing_run_type), intent(inout) :: bearing
      type(column_type), intent(in), target :: columns(:)
      real(wp), intent(in) :: weights(:)
      real(wp) :: axis(3), centre(3), turn(3, 3), arm(3), normal(3), relative(3), across(3)
      real(wp) :: load, spin, weight, semi_axes(2), rolling
      integer :: r, k, b, a, c, body

      do r = 1, size(weights)
         weight = weights(r)
         associate (race => bearing%races(2))
            turn = rotation_matrix(columns(c_attitude)%values(4*race%body - 3:4*race%body, r))
            axis = matmul(turn, race%axis)
            centre = vector(c_position, race%body) + matmul(turn, race%centre)
         end associate
         do k = 1, 2
            associate (race => bearing%races(k))
               race%speed = race%speed + weight*dot_product(vector(c_turning, race%body), axis)
               do a = 1, bearing%arcs
                  do b = 1, bearing%balls
                     c = race%contacts(b, a)
                     load = columns(c_force)%values(c, r)
                     if (.not. load > 0.0_wp) cycle
                     normal = vector(c_normal, c)
                     spin = columns(c_spin)%values(c, r)
                     semi_axes = columns(c_axes)%values(2*c - 1:2*c, r)
                     relative = vector(c_turning, bearing%ball_bodies(b)) &
                        - vector(c_turning, race%body)
                     across = relative - dot_product(relative, normal)*normal
                     rolling = norm2(across)
                     race%loss(1) = race%loss(1) - weight*columns(c_torque)%values(c, r)*spin
                     race%loss(2) = race%loss(2) - weight*dot_product(vector(c_friction, c), &
                        vector(c_slip, c))
                     if (columns(c_moment)%item%is_open()) race%loss(3) = race%loss(3) &
                        - weight*dot_product(vector(c_moment, c), relative)
                     race%load(b, a) = race%load(b, a) + weight*load
                     race%stress(b, a) = race%stress(b, a) + weight*1.5_wp*load &
                        /(pi*product(semi_axes))
                     call add(race%angle, asin(max(-1.0_wp, min(1.0_wp, dot_product(normal, axis) &
                        *merge(1.0_wp, -1.0_wp, k == 1)))))
                     call add(race%major, semi_axes(1))
                     call add(race%minor, semi_axes(2))
                     call add(race%rolling, rolling)
                     call add(race%spin, spin)
                     if (rolling > 0.0_wp) call add(race%pivoting, abs(spin)/rolling)
                  end do
               end do
            end associate
         end do
         do b = 1, bearing%balls
            body = bearing%ball_bodies(b)
            arm = vector(c_position, body) - centre
            arm = arm - dot_product(arm, axis)*axis
            bearing%pitch = bearing%pitch + weight*norm2(arm)/bearing%balls
            bearing%orbit = bearing%orbit + weight*dot_product(cross(arm, vector(c_velocity, &
               body)), axis)/dot_product(arm, arm)/bearing%balls
            if (.not. bearing%has_cage) cycle
            c = bearing%pockets(b)
            bearing%cage_loss = bearing%cage_loss - weight*(columns(c_torque)%values(c, r) &
               *columns(c_spin)%values(c, r) + dot_product(vector(c_friction, c), &
               vector(c_slip, c)))
         end do
         if (bearing%has_cage) bearing%cage = bearing%cage + weight*dot_product( &
            vector(c_turning, bearing%cage_body), axis)
      end do

   contains

      !> A vector of a body or a contact in the row.
      function vector(column, i) result(values)
         integer, intent(in) :: column, i
         real(wp) :: values(3)

         values = columns(column)%values(3*i - 2:3*i, r)
      end function vector

      !> Add to a mean that is weighted by the load.
      subroutine add(mean, x)
         real(wp), intent(inout) :: mean(:, :)
         real(wp), intent(in) :: x

         mean(b, a) = mean(b, a) + weight*load*x
      end subroutine add

   end subroutine add_rows

   !> Divide by the loads; what is never loaded has zeros.
   subroutine finish(bearing)
      type(bearing_run_type), intent(inout) :: bearing
      real(wp) :: weight(bearing%balls, bearing%arcs)
      integer :: k

      do k = 1, 2
         associate (race => bearing%races(k))
            weight = 0.0_wp
            where (race%load > 0.0_wp) weight = 1.0_wp/race%load
            race%angle = race%angle*weight
            race%pivoting = race%pivoting*weight
            race%major = race%major*weight
            race%minor = race%minor*weight
            race%rolling = race%rolling*weight
            race%spin = race%spin*weight
         end associate
      end do
   end subroutine finish

   !> Mean of the sizes of the contact angles, by load [rad].
   pure real(wp) function mean_angle(self)
      class(bearing_run_type), intent(in) :: self
      real(wp) :: total
      integer :: k

      total = 0.0_wp
      mean_angle = 0.0_wp
      do k = 1, 2
         total = total + sum(self%races(k)%load)
         mean_angle = mean_angle + sum(self%races(k)%load*abs(self%races(k)%angle))
      end do
      if (total > 0.0_wp) mean_angle = mean_angle/total
   end function mean_angle

   !> Angular velocity at which the balls orbit if they roll without slip [rad/s].
   pure real(wp) function epicyclic(self)
      class(bearing_run_type), intent(in) :: self
      real(wp) :: ratio

      ratio = self%radius*cos(self%mean_angle())/self%pitch
      epicyclic = 0.5_wp*(self%races(1)%speed*(1.0_wp - ratio) &
         + self%races(2)%speed*(1.0_wp + ratio))
   end function epicyclic

   !> The spot of a ball on a race.
   pure type(race_spot_type) function spot(self, ring, ball)
      class(bearing_run_type), intent(in) :: self
      !> 1 for the inner, 2 for the outer ring.
      integer, intent(in) :: ring
      integer, intent(in) :: ball
      real(wp) :: cosine, sense

      associate (race => self%races(ring))
         sense = merge(1.0_wp, -1.0_wp, ring == 1)
         cosine = cos(race%angle(ball, 1))
         spot%load = race%load(ball, 1)
         spot%semi_axes = [race%major(ball, 1), race%minor(ball, 1)]
         spot%rolling = race%rolling(ball, 1)
         spot%friction = race%friction(ball, 1)
         ! The groove is hollow across the direction of rolling, the inner ring convex along it.
         spot%form = 0.5_wp*[1.0_wp/self%radius + 1.0_wp/race%groove, 1.0_wp/self%radius &
            - sense*cosine/(self%pitch - sense*self%radius*cosine)]
      end associate
   end function spot

   !> Place of a name in a list; 0 for none.
   pure integer function place(list, name)
      type(string_type), intent(in) :: list(:)
      character(len=*), intent(in) :: name
      integer :: i

      place = 0
      do i = 1, size(list)
         if (list(i)%s /= name) cycle
         place = i
         return
      end do
   end function place

   !> Read all texts of a data set.
   subroutine texts(reader, path, values, error)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: path
      type(string_type), allocatable, intent(out) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_item_type) :: item
      integer :: n, i

      call reader%open_item(path, "", item, error)
      if (allocated(error)) return
      n = int(product(item%extents(:item%rank)))
      if (item%class == class_text) then
         call item%read_texts([(0_i8, i=1, item%rank)], item%extents(:item%rank), n, values, error)
      else
         call fatal(error, path // " holds no texts", status_usage)
      end if
      call item%close()
   end subroutine texts

   !> Read all numbers of a data set.
   subroutine reals(reader, path, values, error)
      type(hdf5_reader_type), intent(in) :: reader
      character(len=*), intent(in) :: path
      real(wp), allocatable, intent(out) :: values(:)
      type(error_type), allocatable, intent(out) :: error
      type(hdf5_item_type) :: item
      integer :: i

      call reader%open_item(path, "", item, error)
      if (allocated(error)) return
      if (item%class == class_real) then
         allocate(values(product(item%extents(:item%rank))))
         call item%read([(0_i8, i=1, item%rank)], item%extents(:item%rank), values, error)
      else
         call fatal(error, path // " holds no numbers", status_usage)
      end if
      call item%close()
   end subroutine reals

end module contensou_files_bearing_run
