!> The method of a march: start it, change it for a faster one, and end where it does not get on.
module contensou_integrate_pace
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : power_text
   use contensou_integrate_integrator, only : statistics_type
   use contensou_integrate_memory, only : first_patience
   use contensou_integrate_methods, only : new_integrator
   use contensou_integrate_step, only : march_type
   implicit none(type, external)
   private

   public :: start, refine, counters, set_stop, switch_if_due, change_method_to, &
      sticks, may_leave, watch_pace

   !> Steps between two looks of `auto` at their mean.
   integer, parameter :: steps_between_looks = 200

   !> Steps after which the pace is looked at.
   integer, parameter :: watched_steps = 50000

   !> Steps are hopelessly small below this share of the shortest time that a contact takes [-] ...
   real(wp), parameter :: hopeless = 1.0e-5_wp

   !> ... and if the end is farther than this number of steps.
   real(wp), parameter :: hopeless_steps = 1.0e8_wp

   !> Steps are too small to go on with below this share of the shortest time of a contact [-] ...
   real(wp), parameter :: poor = 1.0e-4_wp

   !> ... if the end is farther than this number of steps, a minute or so of them ...
   real(wp), parameter :: poor_steps = 5.0e6_wp

   !> ... and they were so for this number of looks: a stiff impact passes.
   integer, parameter :: poor_looks = 10

   !> Steps without an event after which it is seen whether friction sticks.
   integer, parameter :: quiet_enough = 2000

   !> Steps to the end from which on another method is to take over where friction sticks.
   real(wp), parameter :: stuck_steps = 1.0e5_wp

contains

   !> Start a method where the march is.
   subroutine start(self, method, error)
      type(march_type), intent(inout) :: self
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method
      !> Set when it cannot be started.
      type(error_type), allocatable, intent(out) :: error

      if (self%memory%tightened > 0 .or. self%plan%method /= method) call refine(self, method)
      call new_integrator(method, self%integrator)
      self%integrator%alert = self%memory%switch%may
      call set_stop(self)
      associate (memory => self%memory, motion => self%motion)
         motion%side = spread(0, 1, motion%n_events)
         if (memory%row > 0) where (.not. memory%undecided) motion%side = merge(-1, 1, &
            memory%closed)
      end associate
      call self%integrator%start(self%motion, method, self%memory%t, self%memory%y, &
         self%plan%t_end, self%plan%max_step, error)
      self%memory%switch%t_look = self%memory%t
      self%memory%switch%steps = 0
      self%steps_at_look = 0_i8
   end subroutine start

   !> Set the tolerance that a method needs to hold rigid contacts.
   subroutine refine(self, method)
      type(march_type), intent(inout) :: self
      !> One of `integrator_methods`.
      character(len=*), intent(in) :: method

      call self%motion%set_tolerance(self%plan%method /= "explicit8" .or. method /= "explicit8", &
         self%memory%tightened)
   end subroutine refine

   !> Counters of a march so far, and of those that it continues.
   function counters(self) result(statistics)
      type(march_type), intent(in) :: self
      type(statistics_type) :: statistics

      statistics = self%memory%switch%before + self%integrator%statistics()
      statistics%derivatives = statistics%derivatives - self%unasked
   end function counters

   !> Let the integration, to be started or restarted, go up to the end of the next ramp of a drive,
   !> no further.
   subroutine set_stop(self)
      type(march_type), intent(inout) :: self

      self%integrator%t_stop = self%motion%system%next_corner(self%memory%t)
      self%motion%system%corner = self%integrator%t_stop
   end subroutine set_stop

   !> Go on with another method where the steps of this one are too short.
   subroutine switch_if_due(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the other method cannot be started.
      type(error_type), allocatable, intent(out) :: error
      type(statistics_type) :: now
      real(wp) :: mean

      associate (switch => self%memory%switch)
         switch%steps = switch%steps + 1
         switch%to_go = max(switch%to_go - 1_i8, 0_i8)
         if (self%integrator%steps_of_trial > 0) call look()
         if (any(self%events /= 0) .or. self%integrator%steps_of_trial > 0) return
         if (switch%steps < steps_between_looks .and. &
            .not. allocated(self%integrator%advice)) return
         ! An event within a step, and one that is none, ends none.
         now = self%integrator%statistics()
         now%steps = now%steps - self%steps_at_look
         mean = (self%memory%t - switch%t_look)/max(now%steps, 1_i8)
         if (switch%method == "explicit8") then
            switch%explicit_step = max(switch%explicit_step, mean)
            call look()
            if (.not. allocated(self%integrator%advice)) return
            deallocate(self%integrator%advice)
            if (switch%to_go > 0 .and. .not. self%integrator%hopeless) return
            switch%to_go = switch%patience - first_patience
            call change_method_to(self, "cvode_bdf", &
               "stability, not accuracy, bounds the steps of explicit8", error)
         else if (now%steps >= steps_between_looks) then
            call look()
            if (switch%to_go > 0) return
            if (switch%explicit_step <= 0.0_wp .or. mean >= switch%explicit_step) return
            switch%to_go = first_patience
            switch%patience = 2_i8*switch%patience
            call change_method_to(self, "explicit8", "the steps of cvode_bdf are " // &
               power_text(mean, 2) // " s, those of explicit8 were " // &
               power_text(switch%explicit_step, 2) // " s", error)
            switch%explicit_step = 0.0_wp
         end if
      end associate

   contains

      !> Begin to look anew.
      subroutine look()
         now = self%integrator%statistics()
         self%steps_at_look = now%steps
         self%memory%switch%t_look = self%memory%t
         self%memory%switch%steps = 0
      end subroutine look

   end subroutine switch_if_due

   !> Go on with another method.
   subroutine change_method_to(self, method, reason, error)
      type(march_type), intent(inout) :: self
      character(len=*), intent(in) :: method
      !> Why.
      character(len=*), intent(in) :: reason
      !> Set when it cannot be started.
      type(error_type), allocatable, intent(out) :: error

      self%memory%switch%before = self%memory%switch%before + self%integrator%statistics()
      call self%integrator%free()
      call start(self, method, error)
      self%memory%switch%method = method
      call self%observer%change_method(self%memory%t, method, reason)
   end subroutine change_method_to

   !> Whether friction that sticks makes the steps of a method so short that it would not come to
   !> the end.
   logical function sticks(self)
      type(march_type), intent(inout) :: self
      real(wp) :: left

      sticks = self%stuck
      self%stuck = .false.
      if (sticks) return
      if (self%motion%system%constraints%n_links == 0 .or. self%memory%switch%may) return
      if (self%memory%switch%method == "cvode_bdf") return
      if (any(self%events /= 0)) self%quiet_steps = 0
      if (self%quiet_steps == 0) self%t_quiet = self%memory%t
      self%quiet_steps = self%quiet_steps + 1
      if (self%quiet_steps <= quiet_enough) return
      left = self%plan%t_end - self%memory%t
      if (left > stuck_steps/self%quiet_steps*(self%memory%t - self%t_quiet)) then
         sticks = has_friction(self, .true.)
      end if
      self%quiet_steps = 0
   end function sticks

   !> Whether a closed contact has friction that may stick.
   pure logical function has_friction(self, rigid)
      type(march_type), intent(in) :: self
      !> Only among rigid contacts.
      logical, intent(in) :: rigid
      integer :: i

      has_friction = .false.
      do i = 1, self%motion%n_events
         associate (contact => self%motion%system%contacts(i))
            has_friction = has_friction .or. ((contact%rigid .or. .not. rigid) .and. &
               merge(contact%closed, self%memory%closed(i), contact%rigid) .and. &
               allocated(contact%law%friction) .and. .not. allocated(contact%tangential))
         end associate
      end do
   end function has_friction

   !> Whether a method that would not come to the end can leave the march to another one that takes
   !> friction in longer steps.
   pure logical function may_leave(self)
      type(march_type), intent(in) :: self

      may_leave = .not. (self%memory%switch%may .or. self%plan%one_method) .and. &
         self%memory%switch%method /= "cvode_bdf"
      if (may_leave) may_leave = has_friction(self, .false.)
   end function may_leave

   !> End a march whose steps have become so small that it would not come to its end.
   subroutine watch_pace(self, error)
      type(march_type), intent(inout) :: self
      !> Set when there is no sense in going on.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: step, left

      self%steps = self%steps + 1
      if (self%steps < watched_steps) return
      step = (self%memory%t - self%t_watch)/self%steps
      left = self%plan%t_end - self%memory%t
      self%looks = self%looks + 1
      if (step >= poor*self%motion%contact_time .or. left <= poor_steps*step) self%looks = 0
      if (self%looks >= poor_looks .or. &
         (step < hopeless*self%motion%contact_time .and. left > hopeless_steps*step)) then
         self%stuck = may_leave(self)
         if (.not. self%stuck) then
            call fatal(error, "the steps have shrunk to " // power_text(step, 2) // " s, and " // &
               power_text(left/step, 2) // " more would be needed")
            return
         end if
         self%looks = 0
      end if
      self%t_watch = self%memory%t
      self%steps = 0
      self%motion%system%trouble = 0
   end subroutine watch_pace

end module contensou_integrate_pace
