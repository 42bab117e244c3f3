!> Conditions that end a march before the end of time.
module contensou_integrate_ends
   use contensou_base_errors, only : error_type, status_failed
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : contact_point_type, trouble_apart, trouble_conforming, &
      trouble_sunk
   use contensou_integrate_checks, only : check_balance
   use contensou_integrate_observer, only : event_touch
   use contensou_integrate_step, only : kept_type, look_at_gaps, march_type, open_step, &
      restore_workspace
   implicit none(type, external)
   private

   public :: tell_event, watch_stops, end_here, heed_conforming

   !> Ratio of the curvatures below which surfaces as good as conform: where a march fails, they do.
   real(wp), parameter :: nearly = 1.0e-3_wp

   !> Gap of a contact that is about to close, over the smallest radius.
   real(wp), parameter :: touching = 1.0e-9_wp

contains

   !> Tell the observer of an event, and see whether it ends the march.
   subroutine tell_event(self, kind, contact, error)
      type(march_type), intent(inout) :: self
      !> `event_touch` or `event_lift`.
      integer, intent(in) :: kind
      integer, intent(in) :: contact
      !> Set when the observer failed.
      type(error_type), allocatable, intent(out) :: error

      call self%observer%event(self%memory%t, kind, contact, error)
      if (.not. self%has_stops .or. self%met > 0) return
      self%met = self%memory%stops%of_event(self%plan%stops, kind == event_touch, &
         first_spot(self, contact))
      self%memory%stops%contact = contact
   end subroutine tell_event

   !> The contact of the first spot of the surfaces of a contact.
   pure integer function first_spot(self, contact)
      type(march_type), intent(in) :: self
      integer, intent(in) :: contact

      first_spot = contact - self%motion%system%contacts(contact)%spot + 1
   end function first_spot

   !> If a condition is met within the step, move its end there.
   subroutine watch_stops(self)
      type(march_type), intent(inout) :: self
      type(kept_type) :: kept
      real(wp) :: t_end, t_found, y(self%motion%n)

      associate (memory => self%memory, stops => self%memory%stops, specs => self%plan%stops, &
         bodies => self%motion%system%bodies, before => self%y_before)
         t_end = min(memory%t, self%plan%t_end)
         if (t_end <= self%t_before) return
         t_found = memory%t
         if (.not. stops%near(specs, bodies, self%t_before, before, t_found, memory%y)) return
         call open_step(self, 0.5_wp*(self%t_before + t_end), kept)
         call stops%find(specs, bodies, self%integrator, self%t_before, before, t_end, &
            self%met, t_found)
         if (self%met > 0) call self%integrator%interpolate(t_found, y)
         call restore_workspace(self%motion, kept)
         if (self%met == 0) return
         if (t_found <= self%t_before) y = before
         self%events = 0
         memory%t = t_found
         memory%y = y
         call look_at_gaps(self)
      end associate
   end subroutine watch_stops

   !> A condition is met here: the last row, and no more.
   subroutine end_here(self, error)
      type(march_type), intent(inout) :: self
      !> Set when the observer failed, or the energy is not where it should be.
      type(error_type), allocatable, intent(out) :: error

      associate (memory => self%memory)
         ! What comes after the end of time ends nothing.
         if (memory%row > self%rows) return
         memory%stops%ended_by = self%met
         if (memory%t > (memory%row - 1)*self%plan%interval) call self%observer%sample( &
            self%motion, memory%t, memory%y, error)
         memory%row = self%rows + 1
         if (.not. allocated(error)) call check_balance(self, error)
      end associate
   end subroutine end_here

   !> Where the march has failed and surfaces conform, or nearly do, see whether it is to end there.
   !> A rigid contact does not hold, or steps shrink, before its surfaces conform: that is its
   !> trouble then.
   subroutine heed_conforming(self, error)
      type(march_type), intent(inout) :: self
      !> Why it has failed; not allocated if that is a condition to end.
      type(error_type), allocatable, intent(inout) :: error
      integer :: contact

      if (error%status /= status_failed) return
      associate (system => self%motion%system)
         contact = system%trouble
         if (contact == 0 .or. system%trouble_code /= trouble_conforming) contact = &
            nearly_conforming(self)
         if (contact == 0) return
         if (system%contacts(contact)%rigid .and. system%too_deep == 0 .and. &
            (system%trouble == 0 .or. any(system%trouble_code == [trouble_sunk, trouble_apart]))) &
            then
            system%trouble = contact
            system%trouble_code = trouble_conforming
         end if
      end associate
      call end_where_conforming(self, contact, error)
   end subroutine heed_conforming

   !> End the march where surfaces conform, if that is a condition to end.
   subroutine end_where_conforming(self, contact, error)
      type(march_type), intent(inout) :: self
      integer, intent(in) :: contact
      !> As of `heed_conforming`.
      type(error_type), allocatable, intent(inout) :: error
      integer :: met

      associate (memory => self%memory)
         if (.not. self%has_stops .or. memory%row > self%rows) return
         met = memory%stops%of_conforming(self%plan%stops, first_spot(self, contact))
         if (met == 0) return
         self%met = met
         memory%stops%contact = contact
         if (self%motion%unfound) then
            memory%t = self%t_before
            memory%y = self%y_before
         end if
      end associate
      deallocate(error)
      call end_here(self, error)
   end subroutine end_where_conforming

   !> A contact that is closed or about to be, whose spot is so long that its surfaces as good as
   !> conform; 0 for none.
   integer function nearly_conforming(self) result(contact)
      type(march_type), intent(inout) :: self
      type(contact_point_type) :: at
      real(wp) :: gap

      associate (system => self%motion%system)
         call system%set_poses(self%memory%y)
         do contact = 1, size(system%contacts)
            associate (candidate => system%contacts(contact), &
               a => system%pose(system%contacts(contact)%a), &
               b => system%pose(system%contacts(contact)%b))
               call candidate%find_gap(a, b, gap)
               if (candidate%track%lost) cycle
               if (.not. self%memory%closed(contact) .and. &
                  gap > touching*candidate%law%geometry%smallest_radius()) cycle
               call candidate%locate(a, b, gap, at)
               if (at%curvature_a <= nearly*abs(at%curvature_b)) return
            end associate
         end do
      end associate
      contact = 0
   end function nearly_conforming

end module contensou_integrate_ends
