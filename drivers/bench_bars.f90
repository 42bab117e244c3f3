!> What the kernels are to achieve in `contensou bench kernels`, and what of it they do.
module contensou_drivers_bench_bars
   use contensou_base_kinds, only : wp
   use contensou_drivers_bench_suite, only : kernel_names, suite_type
   implicit none(type, external)
   private

   public :: bar_type, bars_of, met

   !> Something that the kernels are to achieve.
   type :: bar_type
      !> What is measured.
      character(len=64) :: name = ""
      !> What was measured.
      real(wp) :: measured = 0.0_wp
      !> What it is to be.
      real(wp) :: limit = 0.0_wp
      !> Whether it is to be at least that.
      logical :: at_least = .false.
   end type bar_type

contains

   !> What the kernels are to achieve, and do. A rung is named by its kernel and its own name.
   function bars_of(suite) result(bars)
      type(suite_type), intent(in) :: suite
      type(bar_type), allocatable :: bars(:)
      character(len=*), parameter :: exact = "wrench contensou_exact"
      character(len=*), parameter :: simplified = "wrench contensou_simplified"
      character(len=*), parameter :: jacobian = "wrench_jacobian contensou_exact"
      real(wp) :: logarithm

      logarithm = suite%rungs(1)%seconds(1)
      allocate(bars(0))
      call add("K, E: tables over log()", largest(suite, "elliptic_ke tables", "")/logarithm, &
         2.5_wp)
      if (largest(suite, "elliptic_ke boost", "") > 0.0_wp) call add("K, E: Boost over tables", &
         smallest_ratio(suite, "elliptic_ke boost", "elliptic_ke tables"), 2.5_wp, .true.)
      call add("K, E: GSL over tables", smallest_ratio(suite, "elliptic_ke gsl", &
         "elliptic_ke tables"), 25.0_wp, .true.)
      call add("K, E, B, D: error [ulp]", worst(suite, "elliptic tables", "", [1, 2, 3, 4]), 2.5_wp)
      call add("dK/dc, dE/dc: error [ulp]", worst(suite, "elliptic tables", "", [5, 6]), 3.0_wp)
      call add("Hertz, g >= 1e-3: tables over log()", largest(suite, "hertz tables", "full")/ &
         logarithm, 4.0_wp)
      call add("Hertz, g >= 1e-3: Brewe-Hamrock over tables", &
         largest_ratio(suite, "hertz brewe_hamrock", "hertz tables", "full"), 1.0_wp, .true.)
      call add("Hertz, g >= 1e-3: Greenwood over tables", &
         largest_ratio(suite, "hertz greenwood", "hertz tables", "full"), 1.0_wp, .true.)
      call add("Hertz, N, c1: error [ulp]", worst(suite, "hertz tables", "", [1, 4]), 6.0_wp)
      call add("Hertz, a, b: error [ulp]", worst(suite, "hertz tables", "", [2, 3]), 2.5_wp)
      call add("Hertz, p0: error [ulp]", worst(suite, "hertz tables", "", [5]), 4.0_wp)
      call add("exact wrench: error [f N, f N a]", worst(suite, exact, "", [1, 2]), 5.0e-15_wp)
      call add("exact wrench, circle: relative error of T", worst(suite, exact, "circle", [3]), &
         1.0e-12_wp)
      call add("exact wrench, k = 0.3: relative error of T", worst(suite, exact, "k0.3_", [3]), &
         1.0e-12_wp)
      call add("exact Jacobian: error over the largest entry", worst(suite, jacobian, "", [4]), &
         1.0e-13_wp)
      call add("curved spot within 1e-10: error [f N, f N a]", &
         worst(suite, "curved_wrench within_1e-10", "", [1, 2]), 1.0e-10_wp)
      call add("curved spot within 1e-6: error [f N, f N a]", &
         worst(suite, "curved_wrench within_1e-6", "", [1, 2]), 1.0e-5_wp)
      call add("inside, circle: exact over simplified", &
         largest_ratio(suite, exact, simplified, "circle_inside"), 1.3_wp)
      call add("inside, k = 0.3: exact over simplified", &
         largest_ratio(suite, exact, simplified, "k0.3_inside"), 1.3_wp)
      call add("inside, k = 0.05: exact over simplified", &
         largest_ratio(suite, exact, simplified, "k0.05_inside"), 1.3_wp)
      call add("outside, log u even: exact [ns]", 1.0e9_wp*largest(suite, exact, "_outside"), &
         max(150.0_wp, 25.0e9_wp*logarithm))
      call add("outside, near the rim: exact [ns]", 1.0e9_wp*largest(suite, exact, "_rim"), &
         max(150.0_wp, 25.0e9_wp*logarithm))
      call add("inside: exact with Jacobian over exact", &
         largest_ratio(suite, jacobian, exact, "_inside"), 1.7_wp)
      call add("outside: exact with Jacobian over exact", &
         largest_ratio(suite, jacobian, exact, "_outside"), 1.7_wp)
      call add("near the rim: exact with Jacobian over exact", &
         largest_ratio(suite, jacobian, exact, "_rim"), 1.7_wp)

   contains

      !> Add a bar.
      subroutine add(name, measured, limit, at_least)
         character(len=*), intent(in) :: name
         real(wp), intent(in) :: measured
         !> What it is to be.
         real(wp), intent(in) :: limit
         !> Whether it is to be at least that; at most if not given.
         logical, intent(in), optional :: at_least

         bars = [bars, bar_type(name, measured, limit, .false.)]
         if (present(at_least)) bars(size(bars))%at_least = at_least
      end subroutine add

   end function bars_of

   !> Largest time of a rung [s]; 0 if there is none of this name.
   pure real(wp) function largest(suite, rung, place)
      type(suite_type), intent(in) :: suite
      character(len=*), intent(in) :: rung
      !> Part of the names of the cases.
      character(len=*), intent(in) :: place
      integer :: i

      largest = 0.0_wp
      do i = 1, size(suite%rungs)
         if (fits(suite, i, rung, place)) largest = max(largest, suite%rungs(i)%seconds(1))
      end do
   end function largest

   !> Largest ratio of the times of two rungs on the same case.
   pure real(wp) function largest_ratio(suite, rung, other, place)
      type(suite_type), intent(in) :: suite
      character(len=*), intent(in) :: rung, other
      !> Part of the names of the cases.
      character(len=*), intent(in) :: place
      integer :: i

      largest_ratio = 0.0_wp
      do i = 1, size(suite%rungs)
         if (fits(suite, i, rung, place)) largest_ratio = max(largest_ratio, &
            ratio_to(suite, i, other))
      end do
   end function largest_ratio

   !> Smallest ratio of the times of two rungs on the same case, where the first has all results.
   pure real(wp) function smallest_ratio(suite, rung, other)
      type(suite_type), intent(in) :: suite
      character(len=*), intent(in) :: rung, other
      integer :: i

      smallest_ratio = huge(smallest_ratio)
      do i = 1, size(suite%rungs)
         if (fits(suite, i, rung, "") .and. suite%rungs(i)%misses == 0) smallest_ratio = &
            min(smallest_ratio, ratio_to(suite, i, other))
      end do
   end function smallest_ratio

   !> Ratio of the time of a rung to that of another on the case of the same name.
   pure real(wp) function ratio_to(suite, i, other)
      type(suite_type), intent(in) :: suite
      !> Index of the rung.
      integer, intent(in) :: i
      character(len=*), intent(in) :: other
      integer :: j

      ratio_to = 0.0_wp
      associate (rungs => suite%rungs, cases => suite%cases)
         do j = 1, size(rungs)
            if (.not. fits(suite, j, other, "")) cycle
            if (cases(rungs(j)%place)%name == cases(rungs(i)%place)%name) ratio_to = &
               rungs(i)%seconds(1)/rungs(j)%seconds(1)
         end do
      end associate
   end function ratio_to

   !> Whether a rung has this name, and its case one with that part.
   pure logical function fits(suite, i, rung, place)
      type(suite_type), intent(in) :: suite
      !> Index of the rung.
      integer, intent(in) :: i
      character(len=*), intent(in) :: rung
      character(len=*), intent(in) :: place

      associate (c => suite%cases(suite%rungs(i)%place))
         fits = trim(kernel_names(c%kernel)) // " " // suite%rungs(i)%name == rung .and. &
            index(c%name, place) > 0
      end associate
   end function fits

   !> Largest error of some quantities of a rung; huge if there are arguments without a result.
   pure real(wp) function worst(suite, rung, place, quantities)
      type(suite_type), intent(in) :: suite
      character(len=*), intent(in) :: rung
      !> Part of the names of the cases.
      character(len=*), intent(in) :: place
      integer, intent(in) :: quantities(:)
      integer :: i

      worst = 0.0_wp
      do i = 1, size(suite%rungs)
         if (.not. fits(suite, i, rung, place)) cycle
         worst = max(worst, maxval(suite%rungs(i)%error_max(quantities)))
         if (suite%rungs(i)%misses > 0) worst = huge(worst)
      end do
   end function worst

   !> Whether a bar is met.
   pure elemental function met(bar)
      type(bar_type), intent(in) :: bar
      logical :: met

      met = merge(bar%measured >= bar%limit, bar%measured <= bar%limit, bar%at_least)
   end function met

end module contensou_drivers_bench_bars
