!> What the kernels are to achieve in `contensou bench kernels`, and what of it they do.
module contensou_drivers_bench_bars
   use contensou_base_kinds, only : wp
   use contensou_drivers_bench_suite, only : kernel_elliptic, kernel_hertz, kernel_jacobian, &
      kernel_ke, kernel_names, kernel_wrench, suite_type
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

   !> What the kernels are to achieve, and do.
   function bars_of(suite) result(bars)
      type(suite_type), intent(in) :: suite
      type(bar_type), allocatable :: bars(:)
      real(wp) :: logarithm

      logarithm = suite%rungs(1)%seconds(1)
      allocate(bars(0))
      call add("K, E: tables over log()", largest("elliptic_ke", "tables", "")/logarithm, &
         2.5_wp)
      if (has("boost")) call add("K, E: Boost over tables", smallest_ratio("elliptic_ke", &
         "boost", "elliptic_ke", "tables"), 2.5_wp, .true.)
      call add("K, E: GSL over tables", smallest_ratio("elliptic_ke", &
         "gsl", "elliptic_ke", "tables"), 25.0_wp, .true.)
      call add("K, E, B, D: error [ulp]", worst(kernel_elliptic, "tables", "", [1, 2, 3, 4]), &
         2.5_wp)
      call add("dK/dc, dE/dc: error [ulp]", worst(kernel_elliptic, "tables", "", [5, 6]), 3.0_wp)
      call add("Hertz, g >= 1e-3: tables over log()", largest("hertz", "tables", "full")/ &
         logarithm, 4.0_wp)
      call add("Hertz, g >= 1e-3: Brewe-Hamrock over tables", &
         largest_ratio("hertz", "brewe_hamrock", "hertz", "tables", "full"), 1.0_wp, .true.)
      call add("Hertz, g >= 1e-3: Greenwood over tables", &
         largest_ratio("hertz", "greenwood", "hertz", "tables", "full"), 1.0_wp, .true.)
      call add("Hertz, N, c1: error [ulp]", worst(kernel_hertz, "tables", "", [1, 4]), 6.0_wp)
      call add("Hertz, a, b: error [ulp]", worst(kernel_hertz, "tables", "", [2, 3]), 2.5_wp)
      call add("Hertz, p0: error [ulp]", worst(kernel_hertz, "tables", "", [5]), 4.0_wp)
      call add("exact wrench: error [f N, f N a]", worst(kernel_wrench, "contensou_exact", "", &
         [1, 2]), 5.0e-15_wp)
      call add("exact wrench, circle: relative error of T", worst(kernel_wrench, &
         "contensou_exact", "circle", [3]), 1.0e-12_wp)
      call add("exact wrench, k = 0.3: relative error of T", worst(kernel_wrench, &
         "contensou_exact", "k0.3_", [3]), 1.0e-12_wp)
      call add("exact Jacobian: error over the largest entry", worst(kernel_jacobian, &
         "contensou_exact", "", [4]), 1.0e-13_wp)
      call add_ratio("inside, circle: exact over simplified", "wrench", "contensou_exact", &
         "wrench", "contensou_simplified", "circle_inside", 1.3_wp)
      call add_ratio("inside, k = 0.3: exact over simplified", "wrench", "contensou_exact", &
         "wrench", "contensou_simplified", "k0.3_inside", 1.3_wp)
      call add_ratio("inside, k = 0.05: exact over simplified", "wrench", "contensou_exact", &
         "wrench", "contensou_simplified", "k0.05_inside", 1.3_wp)
      call add("outside, log u even: exact [ns]", 1.0e9_wp*largest("wrench", "contensou_exact", &
         "_outside"), max(150.0_wp, 25.0e9_wp*logarithm))
      call add("outside, near the rim: exact [ns]", 1.0e9_wp*largest("wrench", &
         "contensou_exact", "_rim"), max(150.0_wp, 25.0e9_wp*logarithm))
      call add_ratio("inside: exact with Jacobian over exact", "wrench_jacobian", &
         "contensou_exact", "wrench", "contensou_exact", "_inside", 1.7_wp)
      call add_ratio("outside: exact with Jacobian over exact", "wrench_jacobian", &
         "contensou_exact", "wrench", "contensou_exact", "_outside", 1.7_wp)
      call add_ratio("near the rim: exact with Jacobian over exact", "wrench_jacobian", &
         "contensou_exact", "wrench", "contensou_exact", "_rim", 1.7_wp)

   contains

      !> Add a bar.
      subroutine add(name, measured, limit, at_least)
         !> What is measured.
         character(len=*), intent(in) :: name
         !> What was measured.
         real(wp), intent(in) :: measured
         !> What it is to be.
         real(wp), intent(in) :: limit
         !> Whether it is to be at least that; at most if not given.
         logical, intent(in), optional :: at_least
         type(bar_type), allocatable :: longer(:)
         integer :: n

         n = size(bars)
         allocate(longer(n + 1))
         longer(:n) = bars
         longer(n + 1)%name = name
         longer(n + 1)%measured = measured
         longer(n + 1)%limit = limit
         if (present(at_least)) longer(n + 1)%at_least = at_least
         call move_alloc(longer, bars)
      end subroutine add

      !> Add a bar for the largest ratio of two rungs.
      subroutine add_ratio(name, kernel, rung, other_kernel, other_rung, place, limit)
         !> What is measured.
         character(len=*), intent(in) :: name
         !> Kernel of the rung.
         character(len=*), intent(in) :: kernel
         character(len=*), intent(in) :: rung
         !> Kernel of the rung that it is compared with.
         character(len=*), intent(in) :: other_kernel
         character(len=*), intent(in) :: other_rung
         !> Part of the names of the cases.
         character(len=*), intent(in) :: place
         !> What it is to be at most.
         real(wp), intent(in) :: limit

         call add(name, largest_ratio(kernel, rung, other_kernel, other_rung, place), limit)
      end subroutine add_ratio

      !> Whether there is a rung of this name for K and E.
      logical function has(name)
         character(len=*), intent(in) :: name
         integer :: i

         has = .false.
         do i = 1, size(suite%rungs)
            if (suite%cases(suite%rungs(i)%place)%kernel == kernel_ke) then
               has = has .or. suite%rungs(i)%name == name
            end if
         end do
      end function has

      !> Largest time of a rung [s].
      function largest(kernel, rung, place) result(seconds)
         character(len=*), intent(in) :: kernel
         character(len=*), intent(in) :: rung
         !> Part of the names of the cases.
         character(len=*), intent(in) :: place
         real(wp) :: seconds
         integer :: i

         seconds = 0.0_wp
         do i = 1, size(suite%rungs)
            if (fits(i, kernel, rung, place)) seconds = max(seconds, suite%rungs(i)%seconds(1))
         end do
      end function largest

      !> Largest ratio of the times of two rungs on the same case.
      function largest_ratio(kernel, rung, other_kernel, other_rung, place) result(ratio)
         !> Kernel of the rung.
         character(len=*), intent(in) :: kernel
         character(len=*), intent(in) :: rung
         !> Kernel of the rung that it is compared with.
         character(len=*), intent(in) :: other_kernel
         character(len=*), intent(in) :: other_rung
         !> Part of the names of the cases.
         character(len=*), intent(in) :: place
         real(wp) :: ratio
         integer :: i

         ratio = 0.0_wp
         do i = 1, size(suite%rungs)
            if (fits(i, kernel, rung, place)) ratio = max(ratio, ratio_to(i, other_kernel, &
               other_rung))
         end do
      end function largest_ratio

      !> Smallest ratio of the times of two rungs on the same case, where the first has all results.
      real(wp) function smallest_ratio(kernel, rung, other_kernel, other_rung)
         !> Kernel of the rung.
         character(len=*), intent(in) :: kernel
         character(len=*), intent(in) :: rung
         !> Kernel of the rung that it is compared with.
         character(len=*), intent(in) :: other_kernel
         character(len=*), intent(in) :: other_rung
         integer :: i

         smallest_ratio = huge(smallest_ratio)
         do i = 1, size(suite%rungs)
            if (fits(i, kernel, rung, "") .and. suite%rungs(i)%misses == 0) then
               smallest_ratio = min(smallest_ratio, ratio_to(i, other_kernel, other_rung))
            end if
         end do
      end function smallest_ratio

      !> Ratio of the time of a rung to that of another on the case of the same name.
      real(wp) function ratio_to(i, kernel, rung)
         !> Index of the rung.
         integer, intent(in) :: i
         !> Kernel of the other.
         character(len=*), intent(in) :: kernel
         !> The other.
         character(len=*), intent(in) :: rung
         integer :: j

         ratio_to = 0.0_wp
         do j = 1, size(suite%rungs)
            if (.not. fits(j, kernel, rung, "")) cycle
            if (suite%cases(suite%rungs(j)%place)%name == &
               suite%cases(suite%rungs(i)%place)%name) then
               ratio_to = suite%rungs(i)%seconds(1)/suite%rungs(j)%seconds(1)
            end if
         end do
      end function ratio_to

      !> Whether a rung is of this kernel and name, and its case of such a name.
      logical function fits(i, kernel, rung, place)
         !> Index of the rung.
         integer, intent(in) :: i
         character(len=*), intent(in) :: kernel
         character(len=*), intent(in) :: rung
         !> Part of the name of the case.
         character(len=*), intent(in) :: place

         associate (c => suite%cases(suite%rungs(i)%place))
            fits = kernel_names(c%kernel) == kernel .and. suite%rungs(i)%name == rung .and. &
               index(c%name, place) > 0
         end associate
      end function fits

      !> Largest error of some quantities of a rung; huge if there are arguments without a result.
      real(wp) function worst(kernel, rung, place, quantities)
         integer, intent(in) :: kernel
         character(len=*), intent(in) :: rung
         !> Part of the names of the cases.
         character(len=*), intent(in) :: place
         integer, intent(in) :: quantities(:)
         integer :: i

         worst = 0.0_wp
         do i = 1, size(suite%rungs)
            if (.not. fits(i, trim(kernel_names(kernel)), rung, place)) cycle
            if (suite%rungs(i)%misses > 0) then
               worst = huge(worst)
               return
            end if
            worst = max(worst, maxval(suite%rungs(i)%error_max(quantities)))
         end do
      end function worst

   end function bars_of

   !> Whether a bar is met.
   pure elemental function met(bar)
      type(bar_type), intent(in) :: bar
      logical :: met

      met = merge(bar%measured >= bar%limit, bar%measured <= bar%limit, bar%at_least)
   end function met

end module contensou_drivers_bench_bars
