!> What an output file says of a motion: the quantities of a row, and the summary of a run. Files
!> and tables of sweeps hold the same numbers because both take them from here.
module contensou_study_quantities
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : i8, wp
   use contensou_contact_geometry, only : pose_type
   use contensou_dynamics_scene, only : turns_by_drive
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, drive_loads, &
      energies, report_contact
   use contensou_integrate_integrator, only : statistics_type
   implicit none(type, external)
   private

   public :: quantity_type, row_type, summary_type
   public :: row_quantities, summary_quantities, state_quantities, n_quantities, components_of
   public :: summary_values, final_state, state_size, q_drive_force, q_drive_torque

   !> A quantity of a row, of the summary or of the final state.
   type :: quantity_type
      character(len=21) :: name
      !> Dimensions after time, separated by a blank.
      character(len=12) :: dims
      character(len=7) :: units
      !> Description.
      character(len=103) :: long_name
      !> Whether it is a count.
      logical :: is_integer = .false.
   end type quantity_type

   !> Places of the quantities of a row.
   integer, parameter :: q_time = 1, q_position = 2, q_velocity = 3, q_angular_velocity = 4, &
      q_quaternion = 5, q_kinetic = 6, q_potential = 7, q_elastic = 8, q_friction = 9, &
      q_damping = 10, q_applied = 11, q_drive_force = 12, q_drive_torque = 13, q_error = 14, &
      q_gap = 15, q_normal = 16, q_force = 17, q_torque = 18, q_slip = 19, q_spin = 20, &
      q_axes = 21

   !> Number of the quantities of a row.
   integer, parameter :: n_quantities = 21

   type(quantity_type), parameter :: row_quantities(n_quantities) = [ &
      quantity_type("time", "", "s", "time"), &
      quantity_type("position", "body xyz", "m", "centre of mass"), &
      quantity_type("velocity", "body xyz", "m s-1", "velocity of the centre of mass"), &
      quantity_type("angular_velocity", "body xyz", "rad s-1", &
      "angular velocity, inertial frame"), &
      quantity_type("quaternion", "body wxyz", "1", "attitude, body to inertial frame"), &
      quantity_type("energy_kinetic", "", "J", "kinetic energy"), &
      quantity_type("energy_potential", "", "J", &
      "potential energy of gravity, zero at the origin"), &
      quantity_type("energy_elastic", "", "J", "elastic energy of the contacts"), &
      quantity_type("work_friction", "", "J", &
      "energy lost in friction and rolling resistance so far"), &
      quantity_type("work_damping", "", "J", "energy lost in damping so far"), &
      quantity_type("work_applied", "", "J", &
      "energy supplied by applied loads and prescribed motions so far"), &
      quantity_type("drive_force", "body xyz", "N", &
      "force that keeps a prescribed motion against the contacts, inertial frame"), &
      quantity_type("drive_torque", "body xyz", "N m", "torque about the centre of mass that " // &
      "keeps a prescribed rotation against the contacts, inertial frame"), &
      quantity_type("energy_error", "", "J", &
      "residual of the energy balance since the beginning"), &
      quantity_type("gap", "contact", "m", &
      "signed distance of the undeformed surfaces, negative for overlap"), &
      quantity_type("normal_force", "contact", "N", "normal force"), &
      quantity_type("friction_force", "contact xyz", "N", &
      "friction force on body B, inertial frame"), &
      quantity_type("friction_torque", "contact", "N m", &
      "friction torque on body B about the normal from A to B"), &
      quantity_type("slip_velocity", "contact xyz", "m s-1", &
      "slip velocity of B against A, inertial frame; zero while open"), &
      quantity_type("spin", "contact", "rad s-1", &
      "spin of B against A about the normal; zero while open"), &
      quantity_type("semi_axes", "contact axis", "m", "semi-axes of the contact spot")]

   !> Scalars of the summary of a run, without its CPU time, in the order of `summary_values`.
   type(quantity_type), parameter :: summary_quantities(*) = [ &
      quantity_type("time", "", "s", "time reached"), &
      quantity_type("rows", "", "1", "rows of the trajectory", .true.), &
      quantity_type("touches", "", "1", "touch events", .true.), &
      quantity_type("lifts", "", "1", "lift-off events", .true.), &
      quantity_type("energy_initial", "", "J", "energy at the beginning"), &
      quantity_type("energy_error", "", "J", "largest absolute residual of the energy balance"), &
      quantity_type("energy_error_relative", "", "1", "largest residual over the initial energy"), &
      quantity_type("work_friction", "", "J", "energy lost in friction"), &
      quantity_type("work_damping", "", "J", "energy lost in damping"), &
      quantity_type("work_applied", "", "J", &
      "energy supplied by applied loads and prescribed motions"), &
      quantity_type("steps", "", "1", "steps", .true.), &
      quantity_type("right_hand_sides", "", "1", "evaluations of the right-hand side", .true.)]

   !> Numbers of the final state per body.
   integer, parameter :: state_size = 13

   !> Quantities of the final state, in the order of `final_state`.
   type(quantity_type), parameter :: state_quantities(*) = [ &
      quantity_type("position", "body xyz", "m", "final centre of mass"), &
      quantity_type("velocity", "body xyz", "m s-1", "final velocity"), &
      quantity_type("angular_velocity", "body xyz", "rad s-1", &
      "final angular velocity, inertial frame"), &
      quantity_type("quaternion", "body wxyz", "1", "final attitude, body to inertial frame")]

   !> A row.
   type :: row_type
      !> Numbers, one quantity after the other, components first, then bodies or contacts.
      real(wp), allocatable :: values(:)
      !> Number before the first one of each quantity.
      integer :: start(n_quantities) = 0
      !> Numbers of each quantity; 0 where the scene does not have it.
      integer :: width(n_quantities) = 0
   contains
      !> Make room for the rows of a system.
      procedure :: prepare => prepare_row
      !> The row at a state, without the energy error, which the summary adds.
      procedure :: evaluate
   end type row_type

   !> What a run comes down to.
   type :: summary_type
      !> Time reached [s].
      real(wp) :: time = 0.0_wp
      !> Rows written.
      integer(i8) :: rows = 0
      integer(i8) :: touches = 0
      !> Lift-offs.
      integer(i8) :: lifts = 0
      !> Energy at the beginning [J].
      real(wp) :: initial_energy = 0.0_wp
      !> Largest absolute residual of the energy balance [J].
      real(wp) :: largest_error = 0.0_wp
      !> That over the initial energy, or over the largest kinetic energy if that is zero; with
      !> applied loads or prescribed motions over the largest of these and of the energy supplied
      !> [-].
      real(wp) :: relative_error = 0.0_wp
      !> Work lost in friction [J].
      real(wp) :: work_friction = 0.0_wp
      !> Work lost in damping [J].
      real(wp) :: work_damping = 0.0_wp
      !> Work supplied by applied loads and drives [J].
      real(wp) :: work_applied = 0.0_wp
      !> Largest kinetic energy so far [J].
      real(wp) :: largest_kinetic = 0.0_wp
      !> Largest energy supplied or taken by loads and drives so far [J].
      real(wp) :: largest_supply = 0.0_wp
   contains
      procedure :: add_row
      !> Set the energy error of a row that is not added.
      procedure :: complete_row
      procedure :: add_event
      procedure :: exchange => exchange_summary
   end type summary_type

contains

   !> Components of a quantity per body or contact.
   pure function components_of(quantity) result(components)
      type(quantity_type), intent(in) :: quantity
      integer :: components

      components = 1
      if (index(quantity%dims, " xyz") > 0) components = 3
      if (index(quantity%dims, " wxyz") > 0) components = 4
      if (index(quantity%dims, " axis") > 0) components = 2
   end function components_of

   !> Make room for the rows of a system.
   subroutine prepare_row(self, system)
      class(row_type), intent(inout) :: self
      !> The equations of motion.
      type(system_type), intent(in) :: system
      integer :: i, before

      before = 0
      do i = 1, n_quantities
         self%width(i) = components_of(row_quantities(i))
         if (index(row_quantities(i)%dims, "body") == 1) self%width(i) = &
            self%width(i)*size(system%bodies)
         if (index(row_quantities(i)%dims, "contact") == 1) self%width(i) = &
            self%width(i)*size(system%contacts)
         if (any(i == [q_drive_force, q_drive_torque]) .and. .not. &
            any(turns_by_drive(system%bodies%motion))) self%width(i) = 0
         self%start(i) = before
         before = before + self%width(i)
      end do
      if (allocated(self%values)) deallocate(self%values)
      allocate(self%values(before))
   end subroutine prepare_row

   !> The row at a state.
   subroutine evaluate(self, system, t, y)
      !> The row, prepared.
      class(row_type), intent(inout) :: self
      !> The equations of motion; their workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      type(pose_type) :: pose
      type(contact_report_type) :: report
      real(wp) :: quaternion(4), kinetic, potential, elastic
      real(wp) :: force(3, size(system%bodies)), torque(3, size(system%bodies))
      integer :: i

      associate (v => self%values, s => self%start)
         v(s(q_time) + 1) = t
         do i = 1, size(system%bodies)
            call system%pose_of(y, i, pose, quaternion)
            v(s(q_position) + 3*i - 2:s(q_position) + 3*i) = pose%position
            v(s(q_velocity) + 3*i - 2:s(q_velocity) + 3*i) = pose%velocity
            v(s(q_angular_velocity) + 3*i - 2:s(q_angular_velocity) + 3*i) = pose%spin
            v(s(q_quaternion) + 4*i - 3:s(q_quaternion) + 4*i) = quaternion
         end do
         elastic = 0.0_wp
         call begin_report(system, t, y)
         do i = 1, size(system%contacts)
            call report_contact(system, i, report)
            elastic = elastic + report%elastic_energy
            v(s(q_gap) + i) = report%at%gap
            v(s(q_normal) + i) = report%load%normal_force
            v(s(q_force) + 3*i - 2:s(q_force) + 3*i) = report%load%friction_force
            v(s(q_torque) + i) = report%load%friction_torque
            v(s(q_slip) + 3*i - 2:s(q_slip) + 3*i) = report%slip
            v(s(q_spin) + i) = report%spin
            v(s(q_axes) + 2*i - 1:s(q_axes) + 2*i) = report%semi_axes
         end do
         if (self%width(q_drive_force) > 0) then
            call drive_loads(system, force, torque)
            do i = 1, size(system%bodies)
               v(s(q_drive_force) + 3*i - 2:s(q_drive_force) + 3*i) = force(:, i)
               v(s(q_drive_torque) + 3*i - 2:s(q_drive_torque) + 3*i) = torque(:, i)
            end do
         end if
         call energies(system, y, kinetic, potential)
         v(s(q_kinetic) + 1) = kinetic
         v(s(q_potential) + 1) = potential
         v(s(q_elastic) + 1) = elastic
         v(s(q_friction) + 1) = work(system%layout%friction)
         v(s(q_damping) + 1) = work(system%layout%damping)
         v(s(q_applied) + 1) = work(system%layout%applied)
         v(s(q_error) + 1) = 0.0_wp
      end associate

   contains

      !> A work of the state [J].
      pure real(wp) function work(place)
         !> Its index; 0 for none.
         integer, intent(in) :: place

         work = 0.0_wp
         if (place > 0) work = y(place)
      end function work

   end subroutine evaluate

   !> Energy of a row less what was supplied, plus what was lost [J].
   pure function balance(row) result(energy)
      type(row_type), intent(in) :: row
      real(wp) :: energy

      associate (v => row%values, s => row%start)
         energy = v(s(q_kinetic) + 1) + v(s(q_potential) + 1) + v(s(q_elastic) + 1) + &
            v(s(q_friction) + 1) + v(s(q_damping) + 1) - v(s(q_applied) + 1)
      end associate
   end function balance

   !> Set the energy error of a row that is not added.
   pure subroutine complete_row(self, row)
      class(summary_type), intent(in) :: self
      type(row_type), intent(inout) :: row

      row%values(row%start(q_error) + 1) = balance(row) - self%initial_energy
   end subroutine complete_row

   !> Add a row, and set its energy error.
   pure subroutine add_row(self, system, row)
      class(summary_type), intent(inout) :: self
      !> The equations of motion.
      type(system_type), intent(in) :: system
      type(row_type), intent(inout) :: row

      if (self%rows == 0) self%initial_energy = balance(row)
      call self%complete_row(row)
      associate (v => row%values, s => row%start)
         self%time = v(s(q_time) + 1)
         self%rows = self%rows + 1
         self%largest_error = max(self%largest_error, abs(v(s(q_error) + 1)))
         self%largest_kinetic = max(self%largest_kinetic, v(s(q_kinetic) + 1))
         self%work_friction = v(s(q_friction) + 1)
         self%work_damping = v(s(q_damping) + 1)
         self%work_applied = v(s(q_applied) + 1)
      end associate
      self%relative_error = self%largest_error
      if (system%layout%applied > 0) then
         ! What is supplied may be far more than what was there at the beginning.
         self%largest_supply = max(self%largest_supply, abs(self%work_applied))
         self%relative_error = self%largest_error/max(abs(self%initial_energy), &
            self%largest_kinetic, self%largest_supply, tiny(1.0_wp))
      else if (abs(self%initial_energy) > 0.0_wp) then
         self%relative_error = self%largest_error/abs(self%initial_energy)
      else if (self%largest_kinetic > 0.0_wp) then
         self%relative_error = self%largest_error/self%largest_kinetic
      end if
   end subroutine add_row

   !> Add an event.
   pure subroutine add_event(self, is_touch)
      class(summary_type), intent(inout) :: self
      !> Whether a contact touched, not lifted off.
      logical, intent(in) :: is_touch

      if (is_touch) then
         self%touches = self%touches + 1
      else
         self%lifts = self%lifts + 1
      end if
   end subroutine add_event

   !> Write a summary to a checkpoint or read it back.
   subroutine exchange_summary(self, checkpoint)
      class(summary_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("time", self%time)
      call checkpoint%exchange("rows", self%rows)
      call checkpoint%exchange("touches", self%touches)
      call checkpoint%exchange("lifts", self%lifts)
      call checkpoint%exchange("initial_energy", self%initial_energy)
      call checkpoint%exchange("largest_error", self%largest_error)
      call checkpoint%exchange("relative_error", self%relative_error)
      call checkpoint%exchange("work_friction", self%work_friction)
      call checkpoint%exchange("work_damping", self%work_damping)
      call checkpoint%exchange("work_applied", self%work_applied)
      call checkpoint%exchange("largest_kinetic", self%largest_kinetic)
      call checkpoint%exchange("largest_supply", self%largest_supply)
   end subroutine exchange_summary

   !> The scalars of the summary, in the order of `summary_quantities`.
   pure function summary_values(summary, statistics) result(values)
      type(summary_type), intent(in) :: summary
      !> Counters of the integrator.
      type(statistics_type), intent(in) :: statistics
      real(wp) :: values(size(summary_quantities))

      associate (s => summary)
         values = [s%time, real(s%rows, wp), real(s%touches, wp), real(s%lifts, wp), &
            s%initial_energy, s%largest_error, s%relative_error, s%work_friction, &
            s%work_damping, s%work_applied, real(statistics%steps, wp), &
            real(statistics%derivatives, wp)]
      end associate
   end function summary_values

   !> The state of the bodies as a summary tells it, `state_size` numbers for each: position,
   !> velocity, angular velocity (inertial frame), quaternion.
   subroutine final_state(system, y, state)
      !> The equations of motion.
      type(system_type), intent(in) :: system
      !> State.
      real(wp), intent(in) :: y(:)
      !> Position [m], velocity [m/s], angular velocity [rad/s], quaternion; (state_size, bodies).
      real(wp), intent(out) :: state(:, :)
      type(pose_type) :: pose
      real(wp) :: quaternion(4)
      integer :: i

      do i = 1, size(system%bodies)
         call system%pose_of(y, i, pose, quaternion)
         state(:, i) = [pose%position, pose%velocity, pose%spin, quaternion]
      end do
   end subroutine final_state

end module contensou_study_quantities
