!> The analytic Jacobian against differences in every shipped scene, at states of its own motion.
module test_jacobian_scenes
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_text, only : string_type
   use contensou_contact_geometry, only : pose_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, report_contact
   use contensou_dynamics_state, only : body_size, spin_of
   use contensou_integrate_observer, only : observer_type
   use contensou_integrate_motion, only : motion_type
   use contensou_study_simulation, only : new_simulation, simulate, simulation_options_type, &
      simulation_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use test_harness, only : check, worst_type
   implicit none(type, external)
   private

   public :: run_jacobian_scenes_tests

   !> Rows of a motion over the number of contacts: an impact is not to fall between two of them. At
   !> the ends of so many parts of the motion the Jacobian is compared, and after a contact has
   !> closed or opened, at no more than so many states in all.
   integer, parameter :: rows_of_contact = 40000, parts = 5, most = 16

   !> Longest time of a motion [s].
   real(wp), parameter :: longest_time = 3.0_wp

   !> Steps of the differences over the scales, each a quarter of the one before; of still shorter
   !> ones rounding makes several alike and wrong.
   integer, parameter :: reaches = 7
   real(wp), parameter :: longest_reach = 0.1_wp

   !> Largest difference of a Jacobian from differences that are themselves good to a tenth of it.
   real(wp), parameter :: bound = 1.0e-6_wp

   !> Share of entries for which no differences are as good as that: there is a kink next to the
   !> state, or the approach of a hard contact has too few digits.
   real(wp), parameter :: undecided_share = 0.06_wp

   !> Keeps the states of a motion.
   type, extends(observer_type) :: keeper_type
      !> Times [s].
      real(wp), allocatable :: t(:)
      !> States.
      real(wp), allocatable :: y(:, :)
      !> Which rigid contacts are closed at these.
      logical, allocatable :: shut(:, :)
      !> Number of them.
      integer :: n = 0
      !> Rows so far.
      integer :: row = 0
      !> Rows of a part.
      integer :: part = 1
      !> Contacts that were closed in the last row.
      integer :: closed = 0
   contains
      procedure :: sample
   end type keeper_type

contains

   !> Run the tests.
   subroutine run_jacobian_scenes_tests(folder)
      !> Folder for a list of the scenes.
      character(len=*), intent(in) :: folder
      character(len=256) :: name
      integer :: unit, status, n

      call execute_command_line("ls inputs/*.nml > " // folder // "/scenes.txt", exitstat=status)
      call check(status == 0, "the shipped scenes are found")
      n = 0
      open(newunit=unit, file=folder // "/scenes.txt", action="read", status="old", iostat=status)
      do while (status == 0)
         read(unit, "(a)", iostat=status) name
         if (status /= 0) exit
         n = n + 1
         call test_scene(trim(name))
      end do
      close(unit)
      call check(n >= 13, "there are shipped scenes")
   end subroutine run_jacobian_scenes_tests

   !> The Jacobian along the motion of a scene.
   subroutine test_scene(name)
      !> Its file.
      character(len=*), intent(in) :: name
      type(scene_file_type) :: file
      type(simulation_type) :: simulation
      type(simulation_options_type) :: options
      type(keeper_type) :: keeper
      type(error_type), allocatable :: error
      type(string_type) :: overrides(0)
      type(worst_type) :: worst, consistent
      integer :: i, undecided, decided, closed

      call read_scene(name, overrides, "", file, error)
      call check(.not. allocated(error), name // ": is read")
      if (allocated(error)) return
      keeper%part = rows_of_contact/size(file%scene%contacts)/parts
      options%t_end = min(file%scene%t_end, longest_time)
      options%interval = options%t_end/(parts*keeper%part)
      options%max_step = 0.0_wp
      call new_simulation(file, simulation, error, options)
      allocate(keeper%t(most), keeper%y(simulation%motion%n, most))
      allocate(keeper%shut(size(file%scene%contacts), most))
      if (.not. allocated(error)) call simulate(simulation, keeper, error)
      call check(.not. allocated(error), name // ": runs")
      if (allocated(error)) return
      call simulation%motion%lay_out_jacobian()
      undecided = 0
      decided = 0
      closed = 0
      do i = 1, keeper%n
         simulation%motion%system%contacts%closed = keeper%shut(:, i)
         if (touches(simulation%motion, keeper%y(:, i))) cycle
         call compare(simulation%motion, keeper%t(i), keeper%y(:, i), i, worst, consistent, &
            decided, undecided, closed)
      end do
      call check(closed > 0, name // ": contacts are closed at some of the states")
      call worst%check_below(bound, name // ": Jacobian against differences")
      if (undecided > 0) call consistent%check_below(10.0_wp, name // &
         ": Jacobian against differences that are less accurate, over their error")
      call check(undecided <= undecided_share*decided, name // &
         ": differences decide, but for " // to_text(undecided) // " of " // to_text(decided))
   end subroutine test_scene

   !> Whether a gap is zero to rounding, where there is no derivative.
   function touches(motion, y) result(does)
      type(motion_type), intent(inout) :: motion
      !> State.
      real(wp), intent(in) :: y(:)
      logical :: does
      real(wp) :: gap(motion%n_events)

      call motion%system%gaps(y, gap)
      does = any(abs(gap) <= 64.0_wp*epsilon(gap)*(1.0_wp + maxval(abs(y))) .and. &
         .not. motion%system%contacts%rigid)
   end function touches

   !> Compare the Jacobian at a state with differences of the fourth order, of those steps for each
   !> entry between which they change least.
   subroutine compare(motion, t, y, sample_number, worst, consistent, decided, undecided, closed)
      type(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Number of the state.
      integer, intent(in) :: sample_number
      !> Largest difference.
      type(worst_type), intent(inout) :: worst
      !> Largest difference over the error of the differences, of the others.
      type(worst_type), intent(inout) :: consistent
      !> Number of entries that could be compared.
      integer, intent(inout) :: decided
      !> Number of entries that could not.
      integer, intent(inout) :: undecided
      !> Number of closed contacts.
      integer, intent(inout) :: closed
      real(wp) :: value(size(motion%row)), matrix(size(y), size(y)), scale(size(y))
      real(wp) :: differences(size(y), reaches), f(size(y), 4), x(size(y)), largest(size(y))
      real(wp) :: found(size(y), size(y)), doubt(size(y), size(y)), change(reaches - 1), h, unit
      real(wp) :: rounding(size(y), reaches), steps(reaches), variation(size(y))
      real(wp), parameter :: share(4) = [-2.0_wp, -1.0_wp, 1.0_wp, 2.0_wp]
      integer :: i, j, k, m

      call set_scales(motion, t, y, scale, closed)
      call motion%jacobian(t, y, value)
      matrix = 0.0_wp
      do j = 1, motion%n
         do i = motion%column_start(j), motion%column_start(j + 1) - 1
            matrix(motion%row(i), j) = value(i)*scale(j)
         end do
      end do
      variation = 0.0_wp
      do j = 1, size(y)
         do m = 1, reaches
            ! A step that the sums with the unknown do not round.
            unit = 4.0_wp*spacing(max(abs(y(j)), scale(j)))
            h = unit*max(anint(longest_reach*0.25_wp**(m - 1)*scale(j)/unit), 1.0_wp)
            do k = 1, 4
               x = y
               x(j) = x(j) + share(k)*h
               call motion%system%derivative(t, x, f(:, k))
            end do
            differences(:, m) = (8.0_wp*(f(:, 3) - f(:, 2)) - (f(:, 4) - f(:, 1))) &
               *(scale(j)/(12.0_wp*h))
            rounding(:, m) = epsilon(h)*maxval(abs(f), dim=2)*(scale(j)/h)
            steps(m) = h
            ! Powers are flat at rest, where they are measured by their curvature.
            if (m == 1) variation = max(variation, maxval(abs(f(:, 2:3) - f(:, [1, 4])), dim=2) &
               *(scale(j)/h))
         end do
         do i = 1, size(y)
            change = abs(differences(i, 2:) - differences(i, :reaches - 1))
            ! Two changes in a row: one may be small by chance, and none is smaller than rounding.
            change(2:) = max(change(2:), change(:reaches - 2), rounding(i, 2:reaches - 1))
            k = 1 + minloc(change(2:), dim=1, mask=steps(3:) < steps(2:reaches - 1))
            found(i, j) = differences(i, k)
            doubt(i, j) = change(k)
         end do
      end do
      largest = max(maxval(abs(found), dim=2), maxval(abs(matrix), dim=2), variation)
      do j = 1, size(y)
         do i = 1, size(y)
            ! What is at rest has nothing but remainders.
            if (largest(i) < 1.0e-30_wp) cycle
            if (doubt(i, j) > 0.1_wp*bound*largest(i)) then
               undecided = undecided + 1
               call consistent%note(abs(matrix(i, j) - found(i, j))/doubt(i, j), sample_number)
            else
               decided = decided + 1
               call worst%note(abs(matrix(i, j) - found(i, j))/largest(i), sample_number)
            end if
         end do
      end do
   end subroutine compare

   !> By how much each unknown may vary: a share of the smallest approach, of what the bodies slide
   !> and of what they turn by.
   subroutine set_scales(motion, t, y, scale, closed)
      type(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> The scales.
      real(wp), intent(out) :: scale(:)
      !> Number of closed contacts, increased.
      integer, intent(inout) :: closed
      type(contact_report_type) :: row
      type(pose_type) :: pose
      real(wp) :: approach, speed, arm, unresolved, q(4)
      integer :: i, k

      approach = 1.0e-3_wp
      speed = 1.0_wp
      arm = 0.0_wp
      call begin_report(motion%system, t, y)
      do i = 1, size(motion%system%contacts)
         call report_contact(motion%system, i, row)
         if (.not. is_closed(motion, i, row)) cycle
         closed = closed + 1
         if (.not. motion%system%contacts(i)%rigid) approach = min(approach, -row%at%gap)
         associate (contact => motion%system%contacts(i))
            unresolved = motion%system%resolution%of(motion%system%pose(contact%a), &
               motion%system%pose(contact%b), row%at%point)
         end associate
         speed = min(speed, max(norm2(row%slip), row%semi_axes(1)*abs(row%spin), &
            sqrt(unresolved)))
         do k = 1, 2
            associate (body => merge(motion%system%contacts(i)%a, motion%system%contacts(i)%b, &
               k == 1))
               if (body == 0) cycle
               call motion%system%pose_of(y, body, pose, q)
               arm = max(arm, norm2(row%at%point - pose%position))
            end associate
         end do
      end do
      arm = max(arm, 1.0e-3_wp)
      scale = 1.0_wp
      do i = 1, size(motion%system%bodies)
         k = body_size*(i - 1)
         scale(k + 1:k + 3) = approach
         ! The angular velocity turns with the body.
         scale(k + 4:k + 7) = 0.5_wp*min(approach/arm, &
            speed/(arm*max(norm2(spin_of(y, i)), 1.0e-3_wp)))
         scale(k + 8:k + 10) = speed
         scale(k + 11:k + 13) = speed/arm
      end do
   end subroutine set_scales

   !> Keep a row.
   subroutine sample(self, motion, t, y, error)
      class(keeper_type), intent(inout) :: self
      class(motion_type), intent(inout) :: motion
      !> Time [s].
      real(wp), intent(in) :: t
      !> State.
      real(wp), intent(in) :: y(:)
      !> Never set.
      type(error_type), allocatable, intent(out) :: error
      type(contact_report_type) :: row
      integer :: i, closed
      logical :: wanted

      closed = 0
      call begin_report(motion%system, t, y)
      do i = 1, size(motion%system%contacts)
         call report_contact(motion%system, i, row)
         if (is_closed(motion, i, row)) closed = closed + 1
      end do
      wanted = modulo(self%row, self%part) == 0 .or. (closed /= self%closed .and. &
         self%n < most - parts)
      self%row = self%row + 1
      self%closed = closed
      if (.not. wanted .or. self%n == most) return
      self%n = self%n + 1
      self%t(self%n) = t
      self%y(:, self%n) = y
      self%shut(:, self%n) = motion%system%contacts%closed
   end subroutine sample

   !> Whether a contact is closed.
   pure function is_closed(motion, index, row) result(is)
      class(motion_type), intent(in) :: motion
      !> Index of the contact.
      integer, intent(in) :: index
      type(contact_report_type), intent(in) :: row
      logical :: is

      associate (contact => motion%system%contacts(index))
         is = merge(contact%closed, row%at%gap < 0.0_wp, contact%rigid)
      end associate
   end function is_closed

end module test_jacobian_scenes
