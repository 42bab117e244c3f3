!> The quantities of the rows of output files, and a row.
!>
!> A quantity is a row of the table in `row_quantities`; the layout of files, their size, their
!> checkpoints and the columns of sweeps follow from it.
module contensou_study_quantities
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_parts, only : part_states
   use contensou_contact_states, only : state_list_type
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_reports, only : creepages, rolling_of
   use contensou_dynamics_scene, only : output_spec_type, turns_by_drive
   use contensou_study_quantity, only : if_curvatures_vary, if_curved, if_driven, if_geometry, &
      if_memory, if_rolling, if_springs, if_states, moment_type, of_bodies, of_contacts, &
      of_springs, quantity_type
   implicit none(type, external)
   private

   public :: row_type, row_quantities, shared_quantities, final_quantities

   !> The quantities, made when they are first asked for: each case of a sweep has a row.
   type(quantity_type), allocatable, target :: table(:)

   !> Values of all quantities at one time, in one array.
   type :: row_type
      type(quantity_type), pointer :: quantities(:) => null()
      !> Numbers, one quantity after the other, components first, then bodies or contacts.
      real(wp), allocatable :: values(:)
      !> Number before the first one of each quantity.
      integer, allocatable :: start(:)
      !> Numbers of each quantity.
      integer, allocatable :: width(:)
      !> Whether the scene has the quantity; it may have no numbers nevertheless.
      logical, allocatable :: has(:)
      !> What the values are taken from.
      type(moment_type) :: at
   contains
      procedure :: prepare
      procedure :: fill
      procedure :: final_state
      procedure :: bytes
   end type row_type

contains

   !> All quantities of a row. What a quantity needs is its row here, and the procedure that takes
   !> its values from a moment; those of the states of parts follow from the tables of the parts.
   function row_quantities() result(rows)
      type(quantity_type), allocatable :: rows(:)
      type(state_list_type), allocatable :: lists(:)
      type(quantity_type) :: row
      integer :: i, j

      rows = [ &
         quantity_type("time", "", "s", "time", time), &
         quantity_type("position", "body xyz", "m", "centre of mass", position, &
         "final centre of mass"), &
         quantity_type("velocity", "body xyz", "m s-1", "velocity of the centre of mass", &
         velocity, "final velocity"), &
         quantity_type("angular_velocity", "body xyz", "rad s-1", &
         "angular velocity, inertial frame", angular_velocity, &
         "final angular velocity, inertial frame"), &
         quantity_type("quaternion", "body wxyz", "1", "attitude, body to inertial frame", &
         quaternion, "final attitude, body to inertial frame"), &
         quantity_type("energy_kinetic", "", "J", "kinetic energy", energy_kinetic), &
         quantity_type("energy_potential", "", "J", &
         "potential energy of gravity, zero at the origin", energy_potential), &
         quantity_type("energy_elastic", "", "J", "elastic energy of the contacts", &
         energy_elastic), &
         quantity_type("work_friction", "", "J", &
         "energy lost in friction and rolling resistance so far", work_friction), &
         quantity_type("work_damping", "", "J", "energy lost in damping so far", work_damping), &
         quantity_type("work_applied", "", "J", &
         "energy supplied by applied loads and prescribed motions so far", work_applied), &
         quantity_type("drive_force", "body xyz", "N", &
         "force that keeps a prescribed motion against the contacts, inertial frame", &
         drive_force, there=if_driven), &
         quantity_type("drive_torque", "body xyz", "N m", "torque about the centre of mass " // &
         "that keeps a prescribed rotation against the contacts, inertial frame", &
         drive_torque, there=if_driven), &
         quantity_type("energy_error", "", "J", &
         "residual of the energy balance since the beginning", energy_error), &
         quantity_type("gap", "contact", "m", &
         "signed distance of the undeformed surfaces, negative for overlap", gap), &
         quantity_type("normal_force", "contact", "N", "normal force", normal_force), &
         quantity_type("friction_force", "contact xyz", "N", &
         "friction force on body B, inertial frame", friction_force), &
         quantity_type("friction_torque", "contact", "N m", &
         "friction torque on body B about the normal from A to B", friction_torque), &
         quantity_type("slip_velocity", "contact xyz", "m s-1", &
         "slip velocity of B against A, inertial frame; zero while open", slip_velocity), &
         quantity_type("spin", "contact", "rad s-1", &
         "spin of B against A about the normal; zero while open", spin), &
         quantity_type("semi_axes", "contact axis", "m", "semi-axes of the contact spot", &
         semi_axes), &
         quantity_type("curvature_force", "contact xyz", "N", &
         "force on body B by which the elastic energy resists a change of the curvatures, " // &
         "inertial frame", curvature_force, there=if_curvatures_vary), &
         quantity_type("curvature_torque", "contact xyz", "N m", &
         "torque of it on body B about the contact point, inertial frame", curvature_torque, &
         there=if_curvatures_vary), &
         quantity_type("spot_moment", "contact xyz", "N m", &
         "moment of friction on body B over a curved spot, in its plane, inertial frame", &
         spot_moment, there=if_curved), &
         quantity_type("contact_point", "contact xyz", "m", "contact point, inertial frame", &
         contact_point, there=if_geometry), &
         quantity_type("contact_normal", "contact xyz", "1", &
         "unit normal from A into B, inertial frame", contact_normal, there=if_geometry), &
         quantity_type("major_direction", "contact xyz", "1", &
         "unit tangent along the major axis of the spot, inertial frame", major_direction, &
         there=if_geometry), &
         quantity_type("energy_tangential", "", "J", &
         "elastic energy of shear and twist of the contacts, part of energy_elastic", &
         energy_tangential, there=if_memory), &
         quantity_type("stuck_share", "contact", "1", "share of the area of the spot that has " // &
         "not slipped in the step of the integration", stuck_share, there=if_memory), &
         quantity_type("tangential_displacement", "contact xyz", "m", &
         "elastic displacement of B against A in the tangent plane, inertial frame", &
         tangential_displacement, there=if_memory), &
         quantity_type("rolling_velocity", "contact xyz", "m s-1", "velocity at which the " // &
         "material of A and B passes the spot, mean of the two, inertial frame; zero while open", &
         rolling_velocity, there=if_rolling), &
         quantity_type("longitudinal_creepage", "contact", "1", "slip velocity along the " // &
         "direction of rolling over the rolling velocity; NaN where nothing rolls", &
         longitudinal_creepage, there=if_rolling), &
         quantity_type("lateral_creepage", "contact", "1", "slip velocity along normal x " // &
         "direction of rolling over the rolling velocity; NaN where nothing rolls", &
         lateral_creepage, there=if_rolling), &
         quantity_type("spin_creepage", "contact", "m-1", &
         "spin over the rolling velocity; NaN where nothing rolls", spin_creepage, &
         there=if_rolling), &
         quantity_type("spring_force", "spring xyz", "N", &
         "force of the spring on body B, inertial frame", spring_force, there=if_springs), &
         quantity_type("spring_torque", "spring xyz", "N m", "torque of the spring on body B " // &
         "about its point, inertial frame", spring_torque, there=if_springs), &
         quantity_type("energy_springs", "", "J", &
         "elastic energy of the springs, part of energy_elastic", energy_springs, &
         there=if_springs)]
      lists = part_states()
      do i = 1, size(lists)
         do j = 1, lists(i)%n
            associate (item => lists(i)%items(j))
               if (any(rows%name == item%name)) cycle
               row = quantity_type(item%name, "contact", item%units, item%long_name, of_part)
               if (item%tangent) row%dims = "contact xyz"
            end associate
            row%there = if_states
            rows = [rows, row]
         end do
      end do
      call rows%set_width()
   end function row_quantities

   !> The same in one table for all. Thread-safe.
   function shared_quantities() result(rows)
      type(quantity_type), pointer :: rows(:)
      type(quantity_type), allocatable :: made(:)

      call lock_texts()
      if (.not. allocated(table)) then
         made = row_quantities()
         call move_alloc(made, table)
      end if
      rows => table
      call unlock_texts()
   end function shared_quantities

   !> The quantities whose values at the end are in the summary, with their text there.
   function final_quantities() result(rows)
      type(quantity_type), allocatable :: rows(:)

      type(quantity_type), pointer :: all_rows(:)

      all_rows => shared_quantities()
      rows = pack(all_rows, all_rows%at_end)
      rows%long_name = rows%final
   end function final_quantities

   !> Make room for the rows of a system.
   subroutine prepare(self, system, output)
      class(row_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> What is wanted.
      type(output_spec_type), intent(in) :: output
      integer :: i, j, n, before

      self%quantities => shared_quantities()
      if (allocated(self%values)) deallocate(self%values, self%start, self%width, self%has)
      n = size(self%quantities)
      allocate(self%start(n), self%width(n), self%has(n))
      before = 0
      do i = 1, size(self%quantities)
         associate (q => self%quantities(i))
            self%width(i) = q%components
            select case (q%of)
            case (of_bodies)
               self%width(i) = self%width(i)*size(system%bodies)
            case (of_contacts)
               self%width(i) = self%width(i)*size(system%contacts)
            case (of_springs)
               self%width(i) = self%width(i)*size(system%springs)
            case default
               continue
            end select
            select case (q%there)
            case (if_driven)
               self%has(i) = any(turns_by_drive(system%bodies%motion))
            case (if_geometry)
               self%has(i) = output%contact_geometry
            case (if_memory)
               self%has(i) = system%remembers
            case (if_rolling)
               self%has(i) = output%rolling
            case (if_springs)
               self%has(i) = size(system%springs) > 0
            case (if_states)
               self%has(i) = any([(system%contacts(j)%states%place(q%name) >= 0, &
                  j=1, size(system%contacts))])
            case (if_curved)
               self%has(i) = any([(allocated(system%contacts(j)%law%curved), &
                  j=1, size(system%contacts))])
            case (if_curvatures_vary)
               self%has(i) = any([(system%contacts(j)%curvatures_vary(), &
                  j=1, size(system%contacts))])
            case default
               self%has(i) = .true.
            end select
            if (.not. self%has(i)) self%width(i) = 0
         end associate
         self%start(i) = before
         before = before + self%width(i)
      end do
      allocate(self%values(before))
   end subroutine prepare

   !> Size of the values in a file [bytes].
   pure integer function bytes(self)
      class(row_type), intent(in) :: self

      bytes = storage_size(self%values)/8*size(self%values)
   end function bytes

   !> Values of the quantities at `at`.
   subroutine fill(self)
      class(row_type), intent(inout) :: self
      integer :: i, j, n, last

      do i = 1, size(self%quantities)
         if (self%width(i) == 0) cycle
         associate (q => self%quantities(i))
            n = q%components
            last = self%start(i)
            do j = 1, self%width(i)/n
               call q%fill(self%at, j, self%values(last + 1:last + n))
               last = last + n
            end do
         end associate
      end do
   end subroutine fill

   !> Values at the end of the quantities that the summary holds, one after the other, (values,
   !> bodies).
   subroutine final_state(self, system, t, y, state)
      !> A row of the system; `at` is changed.
      class(row_type), intent(inout) :: self
      type(system_type), intent(in) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      real(wp), allocatable, intent(out) :: state(:, :)
      integer :: i, j, n, last

      call self%at%look_at_bodies(system, t, y)
      associate (rows => self%quantities)
         last = 0
         do i = 1, size(rows)
            if (rows(i)%at_end) last = last + rows(i)%components
         end do
         allocate(state(last, size(system%bodies)))
         last = 0
         do i = 1, size(rows)
            if (.not. rows(i)%at_end) cycle
            n = rows(i)%components
            do j = 1, size(state, 2)
               call rows(i)%fill(self%at, j, state(last + 1:last + n, j))
            end do
            last = last + n
         end do
      end associate
   end subroutine final_state

   !> A state of a part of a contact; zero if it has no such state.
   subroutine of_part(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)
      integer :: place

      values = 0.0_wp
      place = at%system%contacts(i)%states%place(self%name)
      if (place >= 0) values = at%y(place + 1:place + size(values))
   end subroutine of_part

   subroutine time(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%t
   end subroutine time

   subroutine energy_kinetic(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%kinetic
   end subroutine energy_kinetic

   subroutine energy_potential(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%potential
   end subroutine energy_potential

   subroutine energy_elastic(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%elastic
   end subroutine energy_elastic

   subroutine work_friction(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%work_friction
   end subroutine work_friction

   subroutine work_damping(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%work_damping
   end subroutine work_damping

   subroutine work_applied(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%work_applied
   end subroutine work_applied

   subroutine energy_error(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%energy_error
   end subroutine energy_error

   subroutine position(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%pose(i)%position
   end subroutine position

   subroutine velocity(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%pose(i)%velocity
   end subroutine velocity

   subroutine angular_velocity(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%pose(i)%spin
   end subroutine angular_velocity

   subroutine quaternion(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%quaternion(:, i)
   end subroutine quaternion

   subroutine drive_force(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%drive_force(:, i)
   end subroutine drive_force

   subroutine drive_torque(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%drive_torque(:, i)
   end subroutine drive_torque

   subroutine gap(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%at%gap
   end subroutine gap

   subroutine normal_force(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%load%normal_force
   end subroutine normal_force

   subroutine friction_force(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%load%friction_force
   end subroutine friction_force

   subroutine friction_torque(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%load%friction_torque
   end subroutine friction_torque

   subroutine spot_moment(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%load%curvature_moment
   end subroutine spot_moment

   subroutine slip_velocity(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%slip
   end subroutine slip_velocity

   subroutine spin(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%spin
   end subroutine spin

   subroutine semi_axes(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%semi_axes
   end subroutine semi_axes

   subroutine curvature_force(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%curvature_force(1:3)
   end subroutine curvature_force

   subroutine curvature_torque(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%curvature_force(4:6)
   end subroutine curvature_torque

   subroutine energy_tangential(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = sum(at%contact%stored_tangential)
   end subroutine energy_tangential

   subroutine stuck_share(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%stuck
   end subroutine stuck_share

   subroutine tangential_displacement(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%contact(i)%displacement
   end subroutine tangential_displacement

   subroutine rolling_velocity(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = rolling_of(at%system, i, at%contact(i))
   end subroutine rolling_velocity

   subroutine longitudinal_creepage(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)
      real(wp) :: creep(3)

      creep = creepages(at%contact(i), rolling_of(at%system, i, at%contact(i)))
      values = creep(1)
   end subroutine longitudinal_creepage

   subroutine lateral_creepage(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)
      real(wp) :: creep(3)

      creep = creepages(at%contact(i), rolling_of(at%system, i, at%contact(i)))
      values = creep(2)
   end subroutine lateral_creepage

   subroutine spin_creepage(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)
      real(wp) :: creep(3)

      creep = creepages(at%contact(i), rolling_of(at%system, i, at%contact(i)))
      values = creep(3)
   end subroutine spin_creepage

   subroutine spring_force(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%spring(i)%force
   end subroutine spring_force

   subroutine spring_torque(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%spring(i)%torque
   end subroutine spring_torque

   subroutine energy_springs(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = at%springs
   end subroutine energy_springs

   subroutine contact_point(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = known(at, i, at%contact(i)%at%point)
   end subroutine contact_point

   subroutine contact_normal(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = known(at, i, at%contact(i)%at%normal)
   end subroutine contact_normal

   subroutine major_direction(self, at, i, values)
      class(quantity_type), intent(in) :: self
      type(moment_type), intent(in) :: at
      integer, intent(in) :: i
      real(wp), intent(out) :: values(:)

      values = known(at, i, at%contact(i)%at%major)
   end subroutine major_direction

   !> A vector of the geometry of a contact; not a number where the contact has no place.
   pure function known(at, i, vector)
      type(moment_type), intent(in) :: at
      !> The contact.
      integer, intent(in) :: i
      real(wp), intent(in) :: vector(3)
      real(wp) :: known(3)

      known = vector
      associate (track => at%system%contacts(i)%track)
         if (track%away .or. track%lost) known = ieee_value(known, ieee_quiet_nan)
      end associate
   end function known

end module contensou_study_quantities
