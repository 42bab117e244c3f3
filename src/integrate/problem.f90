!> An initial value problem as the integrators see it.
module contensou_integrate_problem
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: problem_type, least_event, way_columns_of

   !> Value of an event function that is zero, on a side of that.
   real(wp), parameter :: least_event = 1.0e-100_wp

   !> Most unknowns on which the rate of a way depends: velocities of two bodies.
   integer, parameter :: way_columns_of = 12

   !> y' = f(t, y) with error weights and functions whose zeros are events.
   type, abstract :: problem_type
      !> Number of unknowns.
      integer :: n = 0
      !> Number of event functions.
      integer :: n_events = 0
      !> Index of the first entry of each column of the Jacobian, and one beyond the last; not
      !> allocated where there is no Jacobian and differences must do.
      integer, allocatable :: column_start(:)
      !> Row of each entry of the Jacobian, in ascending order within a column.
      integer, allocatable :: row(:)
      !> Steps after which an implicit method renews its Jacobian, >= 1.
      integer :: jacobian_steps = 10
      !> Whether what a step does remains. The lengths of steps are part of the result then: they
      !> are not to depend on rounding. And what sticks rings, on the tangential stiffness, and
      !> hardly decays, but at last leaves nothing to follow: a method looks at the limits of its
      !> stability in each step.
      logical :: remembers = .false.
      !> Number of ways: lengths that a method may integrate beside the unknowns for the sake of its
      !> estimates. They act on nothing, but their errors are those of positions, which have too few
      !> digits to tell them.
      integer :: n_ways = 0
      !> Value of an event function up to which it counts as zero where an integration begins.
      real(wp) :: rounding = 0.0_wp
      !> Sides of zero of such functions there as far as they are known, 1 and -1, else 0. What was
      !> closed is closed, however near it is to lift off. Not allocated: none is known.
      integer, allocatable :: side(:)
      !> Which of them have sides of their own in every state that is set: those of rigid contacts,
      !> whose gaps an impact turns round. Not allocated: none.
      logical, allocatable :: turns(:)
      !> Whether what rings may come to rest: rolling with a law of creep does not end by that.
      logical :: settles = .false.
      !> Whether the event functions are asked for at the very state at which the right-hand side
      !> was evaluated last, so that what both need can stay as it is; set for each time.
      logical :: at_last = .false.
   contains
      procedure :: lay_out_jacobian
      procedure :: jacobian
      procedure :: way_rates
      procedure :: way_errors
      procedure :: flight_errors
      procedure :: way_columns
      procedure :: way_slopes
      !> Right-hand side.
      procedure(derivative_interface), deferred :: derivative
      !> Event functions.
      procedure(events_interface), deferred :: events
      !> Admissible local error of each unknown.
      procedure(admissible_interface), deferred :: admissible_error
   end type problem_type

   abstract interface
      !> Right-hand side.
      subroutine derivative_interface(self, t, y, rate, outside)
         import :: problem_type, wp
         implicit none(type, external)
         class(problem_type), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> Unknowns.
         real(wp), intent(in) :: y(self%n)
         !> Their time derivative.
         real(wp), intent(out) :: rate(self%n)
         !> Whether the state is outside the domain of the model: a smaller step may help.
         logical, intent(out) :: outside
      end subroutine derivative_interface

      !> Event functions.
      subroutine events_interface(self, t, y, g)
         import :: problem_type, wp
         implicit none(type, external)
         class(problem_type), intent(inout) :: self
         !> Time [s].
         real(wp), intent(in) :: t
         !> Unknowns.
         real(wp), intent(in) :: y(:)
         !> Values whose zeros are located.
         real(wp), intent(out) :: g(:)
      end subroutine events_interface

      !> Admissible local error.
      subroutine admissible_interface(self, y, size_of_error)
         import :: problem_type, wp
         implicit none(type, external)
         class(problem_type), intent(in) :: self
         !> Unknowns.
         real(wp), intent(in) :: y(:)
         !> Admissible local error of each unknown, > 0.
         real(wp), intent(out) :: size_of_error(:)
      end subroutine admissible_interface
   end interface

contains

   !> Lay out the Jacobian where an implicit method begins; there is none unless a problem says
   !> otherwise.
   subroutine lay_out_jacobian(self)
      class(problem_type), intent(inout) :: self
   end subroutine lay_out_jacobian

   !> Entries of the Jacobian, in the order of `row`; nothing unless a problem says otherwise.
   subroutine jacobian(self, t, y, value)
      class(problem_type), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> Unknowns.
      real(wp), intent(in) :: y(:)
      !> Derivative of the rate of unknown `row(i)` by the unknown of the column.
      real(wp), intent(out) :: value(:)

      value = 0.0_wp
   end subroutine jacobian

   !> Rates of the ways, where the right-hand side was evaluated last; there are none unless a
   !> problem says otherwise.
   subroutine way_rates(self, rates)
      class(problem_type), intent(inout) :: self
      !> `n_ways` of them.
      real(wp), intent(out) :: rates(:)

      rates = 0.0_wp
   end subroutine way_rates

   !> Admissible local errors where ways are integrated along: those of the ways, and finer ones of
   !> unknowns.
   subroutine way_errors(self, of_unknowns, size_of_error)
      class(problem_type), intent(in) :: self
      !> As `admissible_error` tells them.
      real(wp), intent(inout) :: of_unknowns(:)
      !> > 0.
      real(wp), intent(out) :: size_of_error(:)

      size_of_error = huge(size_of_error)
   end subroutine way_errors

   !> Finer admissible local errors of how bodies in flight tumble; as they are unless a problem
   !> says otherwise.
   pure subroutine flight_errors(self, part, of_unknowns, open)
      class(problem_type), intent(in) :: self
      !> What is admitted, over what is else.
      real(wp), intent(in) :: part
      !> As `admissible_error` tells them.
      real(wp), intent(inout) :: of_unknowns(:)
      !> For each event function, whether it is above zero, where that is known.
      logical, intent(in), optional :: open(:)
   end subroutine flight_errors

   !> Unknowns on which the rate of a way depends.
   subroutine way_columns(self, way, columns)
      class(problem_type), intent(in) :: self
      !> 1 to `n_ways`.
      integer, intent(in) :: way
      !> Their indices, 0 for none.
      integer, intent(out) :: columns(way_columns_of)

      columns = 0
   end subroutine way_columns

   !> Derivatives of the rate of a way, where the right-hand side was evaluated last.
   subroutine way_slopes(self, way, slopes)
      class(problem_type), intent(inout) :: self
      !> 1 to `n_ways`.
      integer, intent(in) :: way
      !> By the unknowns that `way_columns` names.
      real(wp), intent(out) :: slopes(way_columns_of)

      slopes = 0.0_wp
   end subroutine way_slopes

end module contensou_integrate_problem
