!> What a run comes down to: the scalars of the group `/summary` of an output file and of the table
!> of a sweep, which hold the same numbers because both take them from here.
module contensou_study_summary
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_dynamics_equations, only : system_type
   use contensou_integrate_integrator, only : statistics_type
   use contensou_study_quantities, only : row_type
   implicit none(type, external)
   private

   public :: summary_type, summary_quantities, summary_stop

   !> A scalar of the summary.
   type :: scalar_type
      character(len=21) :: name
      !> UDUNITS text.
      character(len=8) :: units
      character(len=64) :: long_name
      !> Whether it is a count.
      logical :: is_integer = .false.
   end type scalar_type

   !> Scalars of the summary of a run, without its CPU time, in the order of `values`.
   type(scalar_type), parameter :: summary_quantities(*) = [ &
      scalar_type("time", "s", "time reached"), &
      scalar_type("rows", "1", "rows of the trajectory", .true.), &
      scalar_type("touches", "1", "touch events", .true.), &
      scalar_type("lifts", "1", "lift-off events", .true.), &
      scalar_type("energy_initial", "J", "energy at the beginning"), &
      scalar_type("energy_error", "J", "largest absolute residual of the energy balance"), &
      scalar_type("energy_error_relative", "1", "largest residual over the initial energy"), &
      scalar_type("work_friction", "J", "energy lost in friction"), &
      scalar_type("work_damping", "J", "energy lost in damping"), &
      scalar_type("work_applied", "J", &
      "energy supplied by applied loads and prescribed motions"), &
      scalar_type("steps", "1", "steps", .true.), &
      scalar_type("right_hand_sides", "1", "evaluations of the right-hand side", .true.), &
      scalar_type("stop", "1", "number of the group stop that ended the run, 0 for none", .true.)]

   !> Which of them is there only if the scene has a group `stop`.
   integer, parameter :: summary_stop = size(summary_quantities)

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
      !> Condition that ended the run, 0 for none; negative if the scene has no conditions.
      integer :: stop = -1
   contains
      procedure :: add_row
      procedure :: look
      procedure :: add_event
      procedure :: exchange
      procedure :: values => values_of
   end type summary_type

contains

   !> A row at a state that does not count.
   subroutine look(self, row, system, t, y, error)
      class(summary_type), intent(in) :: self
      !> The row, prepared.
      type(row_type), intent(inout) :: row
      !> The equations of motion; their workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set where the forces of rigid contacts are not found: there is no row.
      type(error_type), allocatable, intent(out) :: error

      call row%at%look(system, t, y, error)
      if (allocated(error)) return
      row%at%energy_error = row%at%balance() - self%initial_energy
      call row%fill()
   end subroutine look

   !> Count a row at a state.
   subroutine add_row(self, row, system, t, y, error)
      class(summary_type), intent(inout) :: self
      !> The row, prepared.
      type(row_type), intent(inout) :: row
      !> The equations of motion; their workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set where the forces of rigid contacts are not found: there is no row.
      type(error_type), allocatable, intent(out) :: error

      call row%at%look(system, t, y, error)
      if (allocated(error)) return
      associate (at => row%at)
         if (self%rows == 0) self%initial_energy = at%balance()
         at%energy_error = at%balance() - self%initial_energy
         self%time = t
         self%rows = self%rows + 1
         self%largest_error = max(self%largest_error, abs(at%energy_error))
         self%largest_kinetic = max(self%largest_kinetic, at%kinetic)
         self%work_friction = at%work_friction
         self%work_damping = at%work_damping
         self%work_applied = at%work_applied
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
      call row%fill()
   end subroutine add_row

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
   subroutine exchange(self, checkpoint)
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
   end subroutine exchange

   !> The scalars of the summary, in the order of `summary_quantities`.
   pure function values_of(self, statistics) result(values)
      class(summary_type), intent(in) :: self
      !> Counters of the integrator.
      type(statistics_type), intent(in) :: statistics
      real(wp) :: values(size(summary_quantities))

      associate (s => self)
         values = [s%time, real(s%rows, wp), real(s%touches, wp), real(s%lifts, wp), &
            s%initial_energy, s%largest_error, s%relative_error, s%work_friction, &
            s%work_damping, s%work_applied, real(statistics%steps, wp), &
            real(statistics%derivatives, wp), real(s%stop, wp)]
      end associate
   end function values_of

end module contensou_study_summary
