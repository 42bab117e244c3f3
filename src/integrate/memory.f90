!> What a march is to do, and what it needs to go on later where it stopped.
module contensou_integrate_memory
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : i8, wp
   use contensou_dynamics_scene, only : stop_spec_type
   use contensou_integrate_integrator, only : statistics_type
   use contensou_integrate_motion, only : motion_type
   use contensou_integrate_stops, only : stops_type
   implicit none(type, external)
   private

   public :: first_patience, memory_type, plan_type, row_count, switch_type

   !> Steps of `explicit8` after a return to it before which it is not left again.
   integer(i8), parameter :: first_patience = 2000_i8

   !> Which methods `auto` has used, and when another one is due.
   type :: switch_type
      !> Whether the march may change the method.
      logical :: may = .false.
      !> Method in use.
      character(len=11) :: method = ""
      !> Counters of the methods before.
      type(statistics_type) :: before
      !> Time of the last look at the steps [s].
      real(wp) :: t_look = 0.0_wp
      !> Steps since then.
      integer :: steps = 0
      !> What it would be with each return to it twice as long. The next method keeps what that is
      !> more, so that two methods that are equally fast do not take turns for ever, and what is the
      !> wrong one after all takes no more steps each time.
      integer(i8) :: patience = first_patience
      !> Steps to go before the method may be left.
      integer(i8) :: to_go = 0
      !> Largest mean step of `explicit8` between two looks [s]; 0 if it has not been in use.
      real(wp) :: explicit_step = 0.0_wp
   end type switch_type

   !> What a march is to do.
   type :: plan_type
      !> One of `integrator_methods`.
      character(len=11) :: method = ""
      !> End of time [s].
      real(wp) :: t_end = 0.0_wp
      !> Interval of the rows [s].
      real(wp) :: interval = 0.0_wp
      !> Largest step [s], 0 for no bound.
      real(wp) :: max_step = 0.0_wp
      !> Whether compliant contacts are left to no other method, as this one is to be measured.
      logical :: one_method = .false.
      !> Conditions that end the march before; not allocated for none.
      type(stop_spec_type), allocatable :: stops(:)
   end type plan_type

   !> What a march needs to go on later where it stopped, besides what the contacts of its motion
   !> remember.
   type :: memory_type
      !> Time [s].
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: y(:)
      !> Next row; 0 if the march has not begun.
      integer(i8) :: row = 0
      !> Which contacts are closed.
      logical, allocatable :: closed(:)
      !> Which contacts have not left the gap of zero, to rounding, that they had at the beginning.
      logical, allocatable :: undecided(:)
      !> Time up to which the step is bounded, because a contact closes and opens there [s]; 0 for
      !> none.
      real(wp) :: bounded_until = 0.0_wp
      !> Energy at the beginning, with what was lost and without what was supplied [J], and the
      !> largest part of it that has moved since: kinetic or elastic energy, change of the
      !> potential one, work [J].
      real(wp) :: energy = 0.0_wp, energy_moved = 0.0_wp
      !> Potential energy at the beginning [J].
      real(wp) :: potential = 0.0_wp
      !> The most that was lost in friction since it was looked at first here [J].
      real(wp) :: lost = 0.0_wp
      !> Largest share of the energy that moved by which the balance was off; 0 as long as that is
      !> too little to be told.
      real(wp) :: imbalance = 0.0_wp
      !> How many times the tolerance was tightened, as rigid contacts sank in.
      integer :: tightened = 0
      !> The method in use, and what `auto` knows.
      type(switch_type) :: switch
      !> Counters so far.
      type(statistics_type) :: statistics
      !> What is known of the conditions that end the march, and which one has.
      type(stops_type) :: stops
   contains
      procedure :: exchange => exchange_memory
   end type memory_type

contains

   !> Number of rows after the first one: multiples of the interval up to the end, and the end.
   pure function row_count(t_end, interval) result(rows)
      !> End of time [s].
      real(wp), intent(in) :: t_end
      !> Interval of the rows [s].
      real(wp), intent(in) :: interval
      integer(i8) :: rows

      rows = ceiling(t_end/interval*(1.0_wp - 4.0_wp*epsilon(t_end)), i8)
   end function row_count

   !> Write what a march needs to go on, and what the contacts of its motion remember, to a
   !> checkpoint, or read it back.
   subroutine exchange_memory(self, motion, checkpoint)
      class(memory_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      type(checkpoint_type), intent(inout) :: checkpoint
      integer :: i

      if (.not. allocated(self%y)) allocate(self%y(motion%n))
      if (.not. allocated(self%closed)) allocate(self%closed(motion%n_events), &
         self%undecided(motion%n_events))
      call checkpoint%exchange("t", self%t)
      call checkpoint%exchange("state", self%y)
      call checkpoint%exchange("row", self%row)
      call checkpoint%exchange("contacts_closed", self%closed)
      call checkpoint%exchange("contacts_undecided", self%undecided)
      call checkpoint%exchange("bounded_until", self%bounded_until)
      call checkpoint%exchange("energy", self%energy)
      call checkpoint%exchange("energy_moved", self%energy_moved)
      call checkpoint%exchange("potential", self%potential)
      call checkpoint%exchange("imbalance", self%imbalance)
      call self%statistics%exchange(checkpoint)
      call checkpoint%exchange("method", self%switch%method)
      call checkpoint%exchange("patience", self%switch%patience)
      call checkpoint%exchange("to_go", self%switch%to_go)
      call checkpoint%exchange("explicit_step", self%switch%explicit_step)
      call checkpoint%exchange("tightened", self%tightened)
      do i = 1, size(motion%system%contacts)
         call motion%system%contacts(i)%exchange(checkpoint)
      end do
      call self%stops%exchange(checkpoint)
   end subroutine exchange_memory

end module contensou_integrate_memory
