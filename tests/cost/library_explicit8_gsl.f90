!> rk8pd of the GNU Scientific Library: the same pair of Prince and Dormand, with the library's
!> evolution and control of the step.
module library_explicit8_gsl
   use, intrinsic :: iso_c_binding, only : c_associated, c_double, c_f_pointer, c_funloc, &
      c_funptr, c_int, c_loc, c_long, c_null_funptr, c_null_ptr, c_ptr, c_size_t
   use contensou_base_kinds, only : wp
   use cost_problem, only : bracket_type, derivative, gap, handle_type, narrow, &
      outcome_type, resolved, trial
   implicit none(type, external)
   private

   public :: integrate_gsl

   !> `gsl_odeiv2_system`.
   type, bind(c) :: system_type
      !> Right-hand side.
      type(c_funptr) :: derivative
      type(c_funptr) :: jacobian
      !> Number of unknowns.
      integer(c_size_t) :: dimension
      !> What the right-hand side gets.
      type(c_ptr) :: parameters
   end type system_type

   !> `gsl_odeiv2_control_type`.
   type, bind(c) :: control_kind_type
      type(c_ptr) :: name
      !> Make a state.
      type(c_funptr) :: allocate
      !> Set its parameters.
      type(c_funptr) :: init
      !> Length of the next step from the error of the last.
      type(c_funptr) :: adjust
      !> Admissible error of one unknown, for other steppers.
      type(c_funptr) :: error_level
      !> Tell the control of a driver.
      type(c_funptr) :: set_driver
      !> Release the state.
      type(c_funptr) :: free
   end type control_kind_type

   !> `gsl_odeiv2_control`.
   type, bind(c) :: control_type
      !> Its procedures.
      type(c_ptr) :: kind
      type(c_ptr) :: state
   end type control_type

   !> `gsl_odeiv2_evolve`.
   type, bind(c) :: evolution_type
      !> Number of unknowns.
      integer(c_size_t) :: dimension
      !> State at the beginning of the step.
      type(c_ptr) :: y
      !> Error of the step.
      type(c_ptr) :: error
      !> Right-hand side at the beginning of the step.
      type(c_ptr) :: rate_in
      !> Right-hand side at its end.
      type(c_ptr) :: rate_out
      !> Length of the step.
      real(c_double) :: last_step
      !> Steps, also those that the control rejects.
      integer(c_long) :: count
      !> Steps that were rejected.
      integer(c_long) :: failed
      type(c_ptr) :: driver
   end type evolution_type

   !> Codes of the library.
   integer(c_int), parameter :: success = 0_c_int, failure = -1_c_int

   !> What the control did to the step.
   integer(c_int), parameter :: increased = 1_c_int, unchanged = 0_c_int, decreased = -1_c_int

   interface
      !> Make a stepper, as explicit8 does.
      function rk8pd_new(n) result(step) bind(c, name="contensou_rk8pd_new")
         import :: c_ptr, c_size_t
         implicit none(type, external)
         !> Number of unknowns.
         integer(c_size_t), intent(in), value :: n
         type(c_ptr) :: step
      end function rk8pd_new

      !> Take a step.
      function step_apply(step, t, h, y, error, rate_in, rate_out, system) result(code) &
         bind(c, name="gsl_odeiv2_step_apply")
         import :: c_double, c_int, c_ptr, system_type
         implicit none(type, external)
         !> The stepper.
         type(c_ptr), intent(in), value :: step
         !> Time [s].
         real(c_double), intent(in), value :: t
         !> Length of the step [s].
         real(c_double), intent(in), value :: h
         !> State.
         real(c_double), intent(inout) :: y(*)
         !> Error of the step.
         real(c_double), intent(out) :: error(*)
         !> Right-hand side at the beginning, or null.
         type(c_ptr), intent(in), value :: rate_in
         !> Right-hand side at the end, or null.
         type(c_ptr), intent(in), value :: rate_out
         !> The problem.
         type(system_type), intent(in) :: system
         integer(c_int) :: code
      end function step_apply

      !> Release a stepper.
      subroutine step_free(step) bind(c, name="gsl_odeiv2_step_free")
         import :: c_ptr
         implicit none(type, external)
         !> The stepper.
         type(c_ptr), intent(in), value :: step
      end subroutine step_free

      !> Make an evolution.
      function evolve_alloc(n) result(evolution) bind(c, name="gsl_odeiv2_evolve_alloc")
         import :: c_ptr, c_size_t
         implicit none(type, external)
         !> Number of unknowns.
         integer(c_size_t), intent(in), value :: n
         type(c_ptr) :: evolution
      end function evolve_alloc

      !> Take a step whose error is admissible.
      function evolve_apply(evolution, control, step, system, t, t_end, h, y) result(code) &
         bind(c, name="gsl_odeiv2_evolve_apply")
         import :: c_double, c_int, c_ptr, control_type, system_type
         implicit none(type, external)
         type(c_ptr), intent(in), value :: evolution
         type(control_type), intent(in) :: control
         !> The stepper.
         type(c_ptr), intent(in), value :: step
         !> The problem.
         type(system_type), intent(in) :: system
         !> Time [s].
         real(c_double), intent(inout) :: t
         !> End of time [s].
         real(c_double), intent(in), value :: t_end
         !> Length of the next step [s].
         real(c_double), intent(inout) :: h
         !> State.
         real(c_double), intent(inout) :: y(*)
         integer(c_int) :: code
      end function evolve_apply

      !> Release an evolution.
      subroutine evolve_free(evolution) bind(c, name="gsl_odeiv2_evolve_free")
         import :: c_ptr
         implicit none(type, external)
         type(c_ptr), intent(in), value :: evolution
      end subroutine evolve_free

      !> Let the library return codes instead of ending the program.
      function set_error_handler_off() result(handler) bind(c, name="gsl_set_error_handler_off")
         import :: c_funptr
         implicit none(type, external)
         type(c_funptr) :: handler
      end function set_error_handler_off
   end interface

contains

   !> Integrate to the touch.
   !>
   !> `gsl_odeiv2_control_scaled_new` knows admissible errors a_i + b |y_i| with constant a_i and b;
   !> the executable's depend on the speed, not on each component of the velocity. So the control is
   !> one of ours, with the rule of the library's standard one.
   subroutine integrate_gsl(self, outcome, message)
      !> The problem.
      type(handle_type), intent(inout), target :: self
      !> What comes of it.
      type(outcome_type), intent(out) :: outcome
      !> Set when it fails.
      character(len=:), allocatable, intent(out) :: message
      type(system_type) :: system
      type(control_kind_type), target :: kind
      type(control_type) :: control
      type(evolution_type), pointer :: memory
      type(c_ptr) :: step, evolution
      type(c_funptr) :: handler
      type(bracket_type) :: bracket
      real(c_double), allocatable :: y(:), y_old(:), error(:)
      real(c_double) :: t, h, start, finish
      integer(c_size_t) :: n
      integer(c_int) :: code
      integer :: i

      n = size(self%y, kind=c_size_t)
      y = self%y
      allocate(y_old(n), error(n))
      handler = set_error_handler_off()
      system = system_type(c_funloc(gsl_derivative), c_null_funptr, n, c_loc(self))
      kind = control_kind_type(c_null_ptr, c_null_funptr, c_null_funptr, &
         c_funloc(gsl_adjust), c_null_funptr, c_null_funptr, c_null_funptr)
      control = control_type(c_loc(kind), c_loc(self))
      step = rk8pd_new(n)
      evolution = evolve_alloc(n)
      if (.not. (c_associated(step) .and. c_associated(evolution))) then
         message = "there is no memory for GSL"
         return
      end if

      call cpu_time(start)
      t = 0.0_wp
      h = 1.0e-6_wp
      bracket%gap = gap(self, y)
      do while (t < self%t_end)
         y_old = y
         outcome%t = t
         bracket%gap(1) = bracket%gap(2)
         code = evolve_apply(evolution, control, step, system, t, self%t_end, h, y)
         if (code /= success) exit
         bracket%gap(2) = gap(self, y)
         if (bracket%gap(2) <= 0.0_wp) exit
      end do
      outcome%touched = bracket%gap(2) <= 0.0_wp
      if (outcome%touched) then
         bracket%h = [0.0_wp, t - outcome%t]
         i = 0
         do while (.not. resolved(bracket, outcome%t) .and. i < 100)
            i = i + 1
            h = trial(bracket, i)
            y = y_old
            code = step_apply(step, outcome%t, h, y, error, c_null_ptr, c_null_ptr, system)
            if (code /= success) exit
            call narrow(bracket, h, gap(self, y))
         end do
         outcome%t = outcome%t + bracket%h(2)
      else
         outcome%t = t
      end if
      call cpu_time(finish)
      outcome%cpu = finish - start

      call c_f_pointer(evolution, memory)
      outcome%steps = int(memory%count - memory%failed)
      call evolve_free(evolution)
      call step_free(step)
      if (code /= success) message = "GSL cannot go on"
   end subroutine integrate_gsl

   !> Right-hand side for GSL.
   function gsl_derivative(t, y, rate, parameters) result(code) bind(c)
      !> Time [s].
      real(c_double), intent(in), value :: t
      !> State.
      type(c_ptr), intent(in), value :: y
      !> Its time derivative.
      type(c_ptr), intent(in), value :: rate
      !> The problem.
      type(c_ptr), intent(in), value :: parameters
      integer(c_int) :: code
      type(handle_type), pointer :: handle
      real(c_double), pointer, contiguous :: state(:), slope(:)
      logical :: outside

      call c_f_pointer(parameters, handle)
      call c_f_pointer(y, state, [handle%motion%n])
      call c_f_pointer(rate, slope, [handle%motion%n])
      call derivative(handle, t, state, slope, outside)
      ! After this code the library tries again with half of the step.
      code = merge(failure, success, outside)
   end function gsl_derivative

   !> Length of the next step: the rule of the library's standard control, which holds the largest
   !> error of all unknowns over the admissible one between 0.5 and 1.1.
   function gsl_adjust(state, n, order, y, error, rate, h) result(change) bind(c)
      !> The problem.
      type(c_ptr), intent(in), value :: state
      !> Number of unknowns.
      integer(c_size_t), intent(in), value :: n
      !> Order of the method.
      integer(c_int), intent(in), value :: order
      !> State.
      real(c_double), intent(in) :: y(n)
      !> Error of the step.
      real(c_double), intent(in) :: error(n)
      !> Right-hand side.
      type(c_ptr), intent(in), value :: rate
      !> Length of the step [s].
      real(c_double), intent(inout) :: h
      integer(c_int) :: change
      type(handle_type), pointer :: handle
      real(c_double) :: admissible(n)
      real(c_double) :: largest

      call c_f_pointer(state, handle)
      call handle%motion%admissible_error(y, admissible)
      largest = max(maxval(abs(error)/admissible), tiny(h))
      if (largest > 1.1_wp) then
         h = h*max(0.9_wp*largest**(-1.0_wp/order), 0.2_wp)
         change = decreased
      else if (largest < 0.5_wp) then
         h = h*min(max(0.9_wp*largest**(-1.0_wp/(order + 1)), 1.0_wp), 5.0_wp)
         change = increased
      else
         change = unchanged
      end if
   end function gsl_adjust

end module library_explicit8_gsl
