!> What `contensou bench kernels` measures: cases (sets of arguments), rungs (ways to compute),
!> their errors and their times.
!>
!> A batch is one pass of a rung over all arguments of its case, repeated if that is short. In
!> throughput the calls do not depend on each other; in a chain the next argument takes bits of the
!> last results by way of a mask that is zero, which the compiler does not know. Results are
!> returned through arguments of external procedures or kept in a volatile variable.
module contensou_drivers_bench_rungs
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan, ieee_quiet_nan, ieee_value
   use, intrinsic :: iso_c_binding, only : c_double, c_int
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_base_system, only : wall_seconds
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_hertz, only : hertz_kernel, hertz_model_type, hertz_models, &
      hertz_newton_with, hertz_type, new_hertz
   use contensou_contact_spot, only : elliptic_shape, spot_shape_type
   use contensou_contact_vilke, only : vilke_models
   use contensou_contact_wrench, only : wrench_exact_jacobian, wrench_jacobian_kernel, &
      wrench_kernel, wrench_simplified_jacobian
   use contensou_drivers_bench_reference, only : new_rule, qp, reference_elliptic, &
      reference_hertz, reference_wrench, rule_type
   use contensou_special_elliptic, only : complete_elliptic, elliptic_agm, elliptic_gsl, &
      elliptic_kernel, elliptic_model_type, elliptic_models
   use contensou_special_gsl, only : gsl_complete_ke
   implicit none(type, external)
   private

   public :: suite_type, case_type, rung_type, new_suite, check_errors, measure_times
   public :: boost_version, name_length, kernel_names, max_quantities
   public :: kernel_log, kernel_elliptic, kernel_ke, kernel_hertz, kernel_wrench, kernel_jacobian

   !> Length of names.
   integer, parameter :: name_length = 20

   !> Kernels.
   integer, parameter :: kernel_log = 1, kernel_elliptic = 2, kernel_ke = 3, kernel_hertz = 4, &
      kernel_wrench = 5, kernel_jacobian = 6

   !> Their names.
   character(len=*), parameter :: kernel_names(6) = [character(len=name_length) :: "log", &
      "elliptic", "elliptic_ke", "hertz", "wrench", "wrench_jacobian"]

   !> How a rung is called.
   integer, parameter :: way_log = 1, way_elliptic = 2, way_tables_ke = 3, way_boost_ke = 4, &
      way_gsl_ke = 5, way_hertz = 6, way_fixed_hertz = 7, way_wrench = 8, way_jacobian = 9

   !> Arguments in a case.
   integer, parameter :: n_arguments = 2048

   !> Largest number of quantities that a kernel computes.
   integer, parameter :: max_quantities = 6

   !> Largest number of arguments and of results of a kernel.
   integer, parameter :: max_inputs = 4, max_results = 12

   !> Shortest batch [s].
   real(wp), parameter :: batch_time = 4.0e-5_wp

   !> A rung whose pass takes longer is measured in one round of so many.
   real(wp), parameter :: slow_pass = 4.0e-4_wp

   !> See `slow_pass`.
   integer, parameter :: slow_stride = 8

   !> Modulus and multiplier of the random numbers (Park and Miller).
   integer(i8), parameter :: random_modulus = 2147483647_i8, random_multiplier = 48271_i8

   !> A set of arguments for a kernel.
   type :: case_type
      !> Kernel.
      integer :: kernel = 0
      !> Name.
      character(len=name_length) :: name = ""
      !> What is in it.
      character(len=80) :: title = ""
      !> Arguments, (input, number).
      real(wp) :: arguments(max_inputs, n_arguments) = 0.0_wp
      !> Number of arguments that are compared with the reference.
      integer :: checked = 0
      !> Reference, (result, number).
      real(qp), allocatable :: reference(:, :)
      !> Axis ratio of the spot.
      real(wp) :: ratio = 1.0_wp
      !> Shape of the spot.
      type(spot_shape_type) :: shape
      !> Contacts whose curvatures do not change.
      type(hertz_type), allocatable :: contacts(:)
   end type case_type

   !> A way to compute a kernel, on a case.
   type :: rung_type
      !> Name.
      character(len=name_length) :: name = ""
      !> Case.
      integer :: place = 0
      !> How it is called.
      integer :: way = 0
      !> The procedure, if it is one for all elliptic integrals.
      procedure(elliptic_kernel), pointer, nopass :: elliptic => null()
      !> The procedure, if it is one for a contact.
      procedure(hertz_kernel), pointer, nopass :: hertz => null()
      !> The procedure, if it is one for the wrench.
      procedure(wrench_kernel), pointer, nopass :: wrench => null()
      !> The procedure, if it is one for the wrench with its Jacobian.
      procedure(wrench_jacobian_kernel), pointer, nopass :: jacobian => null()
      !> Largest error of each quantity; NaN if there is none.
      real(wp) :: error_max(max_quantities) = 0.0_wp
      !> Median of the errors of each quantity.
      real(wp) :: error_median(max_quantities) = 0.0_wp
      !> Number of arguments without a result.
      integer :: misses = 0
      !> Passes in a batch, in throughput and in a chain.
      integer :: passes(2) = 1
      !> Time of a call in throughput and in a chain [s].
      real(wp) :: seconds(2) = huge(1.0_wp)
   end type rung_type

   !> All that is measured.
   type :: suite_type
      !> Sets of arguments.
      type(case_type), allocatable :: cases(:)
      !> Rungs on them; those of a kernel and case in a row.
      type(rung_type), allocatable :: rungs(:)
   end type suite_type

   interface
      !> Version of Boost, 0 if it is not there.
      function boost_version() result(version) bind(c, name="contensou_boost_version")
         import :: c_int
         implicit none(type, external)
         integer(c_int) :: version
      end function boost_version

      !> K and E of Boost.
      pure subroutine boost_ke(c1, k, e) bind(c, name="contensou_boost_ke")
         import :: c_double
         implicit none(type, external)
         !> Complement c1 = 1 - c of the parameter.
         real(c_double), intent(in), value :: c1
         !> Integral K.
         real(c_double), intent(out) :: k
         !> Integral E.
         real(c_double), intent(out) :: e
      end subroutine boost_ke

      !> K, E and D of Boost.
      pure subroutine boost_ked(c1, k, e, d) bind(c, name="contensou_boost_ked")
         import :: c_double
         implicit none(type, external)
         !> Complement c1 = 1 - c of the parameter.
         real(c_double), intent(in), value :: c1
         !> Integral K.
         real(c_double), intent(out) :: k
         !> Integral E.
         real(c_double), intent(out) :: e
         !> Integral D.
         real(c_double), intent(out) :: d
      end subroutine boost_ked
   end interface

   !> Takes results, so that they are computed.
   real(wp), volatile :: sink = 0.0_wp

   !> Bits of the last results that the next argument takes: none.
   integer(i8), volatile :: no_bits = 0_i8

contains

   !> Everything that is measured, with its arguments.
   subroutine new_suite(suite)
      !> The suite.
      type(suite_type), intent(out) :: suite
      integer(i8) :: state

      state = 20090921_i8
      allocate(suite%cases(0), suite%rungs(0))
      call add_case(suite, kernel_log, "random", "log x even, 1e-6 to 1e6")
      suite%cases(1)%arguments(1, :) = between(state, 1.0e-6_wp, 1.0e6_wp)
      call add_elliptic(suite, state)
      call add_hertz(suite, state)
      call add_wrench(suite, state)
      call add_rungs(suite)
   end subroutine new_suite

   !> Add a case.
   subroutine add_case(suite, kernel, name, title)
      !> The suite.
      type(suite_type), intent(inout) :: suite
      !> Kernel.
      integer, intent(in) :: kernel
      !> Name.
      character(len=*), intent(in) :: name
      !> What is in it.
      character(len=*), intent(in) :: title
      type(case_type), allocatable :: longer(:)
      integer :: n, i

      n = size(suite%cases)
      allocate(longer(n + 1))
      do i = 1, n
         longer(i) = suite%cases(i)
      end do
      longer(n + 1)%kernel = kernel
      longer(n + 1)%name = name
      longer(n + 1)%title = title
      call move_alloc(longer, suite%cases)
   end subroutine add_case

   !> Cases of the elliptic integrals: all of them, and K and E alone.
   subroutine add_elliptic(suite, state)
      !> The suite.
      type(suite_type), intent(inout) :: suite
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      integer :: kernel, n, i

      n = size(suite%cases)
      do kernel = kernel_elliptic, kernel_ke
         call add_case(suite, kernel, "even", "c1 even in (0, 1)")
         call add_case(suite, kernel, "wide", "log c1 even, 1e-300 to 1")
         call add_case(suite, kernel, "near_circle", "c1 = 1 - c, log c even, 1e-16 to 0.1")
      end do
      do i = 1, n_arguments
         suite%cases(n + 1)%arguments(1, i) = uniform(state)
      end do
      suite%cases(n + 2)%arguments(1, :) = between(state, 1.0e-300_wp, 1.0_wp)
      suite%cases(n + 3)%arguments(1, :) = 1.0_wp - between(state, 1.0e-16_wp, 0.1_wp)
      do i = 1, 3
         suite%cases(n + 3 + i)%arguments = suite%cases(n + i)%arguments
      end do
   end subroutine add_elliptic

   !> Cases of Hertz's contact.
   subroutine add_hertz(suite, state)
      !> The suite.
      type(suite_type), intent(inout) :: suite
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      integer :: n, i, j

      n = size(suite%cases)
      call add_case(suite, kernel_hertz, "full", "log g even, 1e-3 to 1")
      call add_case(suite, kernel_hertz, "slender", "log g even, 1e-20 to 1e-3")
      do i = n + 1, n + 2
         associate (x => suite%cases(i)%arguments)
            if (i == n + 1) then
               x(1, :) = between(state, 1.0e-3_wp, 1.0_wp)
            else
               x(1, :) = between(state, 1.0e-20_wp, 1.0e-3_wp)
            end if
            x(2, :) = between(state, 1.0_wp, 1.0e4_wp)
            x(1, :) = x(1, :)*x(2, :)
            x(3, :) = between(state, 1.0e7_wp, 1.0e12_wp)
            x(4, :) = between(state, 1.0e-9_wp, 1.0e-4_wp)
            allocate(suite%cases(i)%contacts(n_arguments))
            do j = 1, n_arguments
               suite%cases(i)%contacts(j) = new_hertz(x(1, j), x(2, j), x(3, j))
            end do
         end associate
      end do
   end subroutine add_hertz

   !> Cases of the wrench, without and with its Jacobian.
   subroutine add_wrench(suite, state)
      !> The suite.
      type(suite_type), intent(inout) :: suite
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      !> Axis ratios, with names and titles.
      real(wp), parameter :: ratios(3) = [1.0_wp, 0.3_wp, 0.05_wp]
      character(len=*), parameter :: names(3) = ["circle", "k0.3  ", "k0.05 "]
      character(len=*), parameter :: titles(3) = ["circle  ", "k = 0.3 ", "k = 0.05"]
      !> Places of the rotation centre, with their bounds of U = u_x^2/k^2 + u_y^2.
      character(len=*), parameter :: places(3) = ["inside ", "rim    ", "outside"]
      character(len=*), parameter :: place_titles(3) = [character(len=60) :: &
         "rotation centre inside the spot, log u even", &
         "rotation centre outside, up to twice the rim, even", &
         "rotation centre outside the spot, log u even, up to 1e3"]
      real(wp) :: u, x, y, spin, scale
      integer :: n, i, j, place, n_cases

      n = size(suite%cases)
      do i = 1, 3
         do place = 1, 3
            call add_case(suite, kernel_wrench, trim(names(i)) // "_" // places(place), &
               trim(titles(i)) // ", " // place_titles(place))
            associate (c => suite%cases(size(suite%cases)))
               c%ratio = ratios(i)
               c%shape = elliptic_shape(ratios(i))
               do j = 1, n_arguments
                  do
                     x = 2.0_wp*pi*uniform(state)
                     u = 10.0_wp**(6.0_wp*uniform(state) - 3.0_wp)
                     y = u*sin(x)
                     x = u*cos(x)
                     scale = hypot(x/ratios(i), y)
                     if (place == 1 .and. scale <= 1.0_wp) exit
                     if (place == 3 .and. scale > 1.0_wp) exit
                     if (place == 2) then
                        u = (1.0_wp + uniform(state))/scale
                        x = u*x
                        y = u*y
                        exit
                     end if
                  end do
                  spin = 10.0_wp**(2.0_wp*uniform(state) - 1.0_wp)
                  c%arguments(1, j) = spin*x
                  c%arguments(2, j) = spin*y
                  c%arguments(3, j) = sign(spin, uniform(state) - 0.5_wp)
               end do
            end associate
         end do
      end do
      n_cases = size(suite%cases)
      do i = n + 1, n_cases
         call add_case(suite, kernel_jacobian, suite%cases(i)%name, suite%cases(i)%title)
         suite%cases(size(suite%cases)) = suite%cases(i)
         suite%cases(size(suite%cases))%kernel = kernel_jacobian
      end do
   end subroutine add_wrench

   !> The rungs of every case.
   subroutine add_rungs(suite)
      !> The suite.
      type(suite_type), intent(inout) :: suite
      type(elliptic_model_type), allocatable :: elliptic(:)
      type(hertz_model_type), allocatable :: hertz(:), vilke(:)
      type(friction_model_type), allocatable :: friction(:)
      type(rung_type) :: rung
      logical :: with_gsl, with_boost
      integer :: place, i

      elliptic = elliptic_models()
      hertz = hertz_models()
      vilke = vilke_models()
      friction = friction_models()
      with_gsl = .false.
      do i = 1, size(elliptic)
         if (elliptic(i)%name == "gsl") with_gsl = associated(elliptic(i)%kernel)
      end do
      with_boost = boost_version() > 0
      do place = 1, size(suite%cases)
         rung = rung_type()
         rung%place = place
         select case (suite%cases(place)%kernel)
         case (kernel_log)
            call add("log", way_log)
         case (kernel_elliptic)
            do i = 1, size(elliptic)
               rung%elliptic => elliptic(i)%kernel
               if (associated(rung%elliptic)) call add(elliptic(i)%name, way_elliptic)
            end do
            rung%elliptic => elliptic_boost
            if (with_boost) call add("boost", way_elliptic)
         case (kernel_ke)
            call add("tables", way_tables_ke)
            if (with_gsl) call add("gsl", way_gsl_ke)
            if (with_boost) call add("boost", way_boost_ke)
         case (kernel_hertz)
            do i = 1, size(hertz)
               rung%hertz => hertz(i)%kernel
               call add(hertz(i)%info%name, way_hertz)
            end do
            rung%hertz => newton_agm
            call add("newton_agm", way_hertz)
            rung%hertz => newton_gsl
            if (with_gsl) call add("newton_gsl", way_hertz)
            rung%hertz => null()
            call add("tables_fixed", way_fixed_hertz)
            do i = 1, size(vilke)
               rung%hertz => vilke(i)%kernel
               call add("vilke_" // vilke(i)%info%name, way_hertz)
            end do
         case (kernel_wrench)
            do i = 1, size(friction)
               rung%wrench => friction(i)%kernel
               if (associated(rung%wrench)) call add(friction(i)%info%name, way_wrench)
            end do
         case default
            rung%jacobian => wrench_simplified_jacobian
            call add("contensou_simplified", way_jacobian)
            rung%jacobian => wrench_exact_jacobian
            call add("contensou_exact", way_jacobian)
         end select
      end do

   contains

      !> Add a rung.
      subroutine add(name, way)
         !> Name.
         character(len=*), intent(in) :: name
         !> How it is called.
         integer, intent(in) :: way
         type(rung_type), allocatable :: longer(:)
         integer :: n

         rung%name = name
         rung%way = way
         n = size(suite%rungs)
         allocate(longer(n + 1))
         longer(:n) = suite%rungs
         longer(n + 1) = rung
         call move_alloc(longer, suite%rungs)
      end subroutine add

   end subroutine add_rungs

   !> Next random number, even in (0, 1).
   function uniform(state) result(x)
      !> State.
      integer(i8), intent(inout) :: state
      real(wp) :: x

      ! Two of them, as one has 31 bits only.
      state = mod(state*random_multiplier, random_modulus)
      x = real(state, wp)
      state = mod(state*random_multiplier, random_modulus)
      x = (x - 1.0_wp + real(state, wp)/real(random_modulus, wp))/real(random_modulus - 1_i8, wp)
   end function uniform

   !> Random numbers whose logarithms are even.
   function between(state, low, high) result(x)
      !> State.
      integer(i8), intent(inout) :: state
      !> Smallest.
      real(wp), intent(in) :: low
      !> Largest.
      real(wp), intent(in) :: high
      real(wp) :: x(n_arguments)
      integer :: i

      do i = 1, n_arguments
         x(i) = min(max(exp(log(low) + uniform(state)*(log(high) - log(low))), low), high)
      end do
   end function between

   !> All elliptic integrals from K, E and D of Boost.
   pure subroutine elliptic_boost(c1, k, e, b, d, dk_dc, de_dc)
      !> Complement c1 = 1 - c of the parameter [-], in [0, 1].
      real(wp), intent(in) :: c1
      !> Integral K [-].
      real(wp), intent(out) :: k
      !> Integral E [-].
      real(wp), intent(out) :: e
      !> Integral B [-].
      real(wp), intent(out) :: b
      !> Integral D [-].
      real(wp), intent(out) :: d
      !> Derivative dK/dc [-].
      real(wp), intent(out) :: dk_dc
      !> Derivative dE/dc [-].
      real(wp), intent(out) :: de_dc

      call boost_ked(c1, k, e, d)
      b = k - d
      dk_dc = b/(c1 + c1)
      de_dc = -0.5_wp*d
   end subroutine elliptic_boost

   !> Contact by Newton's method with the arithmetic-geometric mean.
   pure subroutine newton_agm(curvature_a, curvature_b, modulus, approach, c1, a, b, force, &
      pressure)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Complementary parameter c1 = (b/a)^2 of the spot [-].
      real(wp), intent(out) :: c1
      !> Major semi-axis a [m].
      real(wp), intent(out) :: a
      !> Minor semi-axis b [m].
      real(wp), intent(out) :: b
      !> Force N [N].
      real(wp), intent(out) :: force
      !> Largest pressure p0 [Pa].
      real(wp), intent(out) :: pressure

      call hertz_newton_with(elliptic_agm, curvature_a, curvature_b, modulus, approach, c1, a, b, &
         force, pressure)
   end subroutine newton_agm

   !> Contact by Newton's method with K and E of the GNU Scientific Library.
   pure subroutine newton_gsl(curvature_a, curvature_b, modulus, approach, c1, a, b, force, &
      pressure)
      !> Half relative curvature A along the major axis [1/m], > 0.
      real(wp), intent(in) :: curvature_a
      !> Half relative curvature B along the minor axis [1/m], >= A.
      real(wp), intent(in) :: curvature_b
      !> Effective modulus E* [Pa], > 0.
      real(wp), intent(in) :: modulus
      !> Approach d [m], >= 0.
      real(wp), intent(in) :: approach
      !> Complementary parameter c1 = (b/a)^2 of the spot [-].
      real(wp), intent(out) :: c1
      !> Major semi-axis a [m].
      real(wp), intent(out) :: a
      !> Minor semi-axis b [m].
      real(wp), intent(out) :: b
      !> Force N [N].
      real(wp), intent(out) :: force
      !> Largest pressure p0 [Pa].
      real(wp), intent(out) :: pressure

      call hertz_newton_with(elliptic_gsl, curvature_a, curvature_b, modulus, approach, c1, a, b, &
         force, pressure)
   end subroutine newton_gsl

   !> Errors of all rungs against the reference.
   subroutine check_errors(suite, quick)
      !> The suite.
      type(suite_type), intent(inout), target :: suite
      !> Whether few arguments are to do.
      logical, intent(in) :: quick
      type(case_type), pointer :: c
      real(wp), allocatable :: errors(:, :)
      real(wp) :: results(max_results)
      integer :: i, j, n, n_quantities

      call fill_references(suite, quick)
      do i = 1, size(suite%rungs)
         associate (rung => suite%rungs(i))
            c => suite%cases(rung%place)
            if (c%kernel == kernel_log) cycle
            n_quantities = quantity_count(c%kernel)
            allocate(errors(c%checked, n_quantities))
            n = 0
            do j = 1, c%checked
               call evaluate(rung, c, j, results)
               if (any(ieee_is_nan(results))) cycle
               n = n + 1
               errors(n, :) = errors_of(c, j, results, n_quantities)
            end do
            rung%misses = c%checked - n
            do j = 1, n_quantities
               if (n > 0) then
                  call sort(errors(:n, j))
                  rung%error_max(j) = errors(n, j)
                  rung%error_median(j) = 0.5_wp*(errors((n + 1)/2, j) + errors(n/2 + 1, j))
               else
                  rung%error_max(j) = ieee_value(rung%error_max(j), ieee_quiet_nan)
                  rung%error_median(j) = rung%error_max(j)
               end if
            end do
            deallocate(errors)
         end associate
      end do
   end subroutine check_errors

   !> The references of all cases.
   subroutine fill_references(suite, quick)
      !> The suite.
      type(suite_type), intent(inout) :: suite
      !> Whether few arguments are to do.
      logical, intent(in) :: quick
      type(rule_type) :: rule
      real(qp) :: wrench(3), jacobian(3, 3)
      integer :: i, j

      rule = new_rule()
      do i = 1, size(suite%cases)
         associate (c => suite%cases(i))
            if (c%kernel == kernel_log) cycle
            c%checked = n_arguments
            if (quick) c%checked = 256
            if (any(c%kernel == [kernel_wrench, kernel_jacobian])) c%checked = c%checked/4
            allocate(c%reference(max_results, c%checked))
            if (any(c%kernel == [kernel_ke, kernel_jacobian])) cycle
            do j = 1, c%checked
               associate (x => c%arguments(:, j), results => c%reference(:, j))
                  results = 0.0_qp
                  select case (c%kernel)
                  case (kernel_elliptic)
                     results(:6) = reference_elliptic(real(x(1), qp))
                  case (kernel_hertz)
                     results(:5) = reference_hertz(x(1), x(2), x(3), x(4))
                  case default
                     call reference_wrench(rule, c%ratio, x(1), x(2), x(3), wrench, jacobian)
                     results = [wrench, reshape(jacobian, [9])]
                  end select
               end associate
            end do
         end associate
      end do
      ! The arguments are those of the case of the same name.
      do i = 1, size(suite%cases)
         if (all(suite%cases(i)%kernel /= [kernel_ke, kernel_jacobian])) cycle
         do j = 1, i - 1
            if (suite%cases(j)%kernel == suite%cases(i)%kernel - 1 .and. &
               suite%cases(j)%name == suite%cases(i)%name) then
               suite%cases(i)%reference = suite%cases(j)%reference
            end if
         end do
      end do
   end subroutine fill_references

   !> Number of quantities whose errors are told: as many as `quantities_of` names.
   pure function quantity_count(kernel) result(n)
      !> Kernel.
      integer, intent(in) :: kernel
      integer :: n
      integer, parameter :: counts(6) = [0, 6, 2, 5, 3, 4]

      n = counts(kernel)
   end function quantity_count

   !> Results of a rung for one argument.
   subroutine evaluate(rung, c, j, results)
      !> The rung.
      type(rung_type), intent(in) :: rung
      !> Its case.
      type(case_type), intent(in) :: c
      !> Number of the argument.
      integer, intent(in) :: j
      !> Results in the order of the reference; zero beyond those that the kernel has.
      real(wp), intent(out) :: results(max_results)
      real(wp) :: jacobian(3, 3)
      logical :: found

      results = 0.0_wp
      associate (x => c%arguments(:, j), r => results)
         select case (rung%way)
         case (way_elliptic)
            call rung%elliptic(x(1), r(1), r(2), r(3), r(4), r(5), r(6))
         case (way_tables_ke)
            call complete_elliptic(x(1), r(1), r(2))
         case (way_boost_ke)
            call boost_ke(x(1), r(1), r(2))
         case (way_gsl_ke)
            call gsl_complete_ke(sqrt(1.0_wp - x(1)), r(1), r(2), found)
            if (.not. found) r(1) = ieee_value(r(1), ieee_quiet_nan)
         case (way_hertz)
            call rung%hertz(x(1), x(2), x(3), x(4), r(1), r(2), r(3), r(4), r(5))
         case (way_fixed_hertz)
            r(1) = c%contacts(j)%c1
            call c%contacts(j)%contact(x(4), r(2), r(3), r(4), r(5))
         case (way_wrench)
            call rung%wrench(c%shape, x(1), x(2), x(3), 0.0_wp, .true., r(1), r(2), r(3))
         case default
            call rung%jacobian(c%shape, x(1), x(2), x(3), 0.0_wp, r(:3), jacobian)
            r(4:) = reshape(jacobian, [9])
         end select
      end associate
   end subroutine evaluate

   !> Errors of the quantities for one argument.
   function errors_of(c, j, results, n_quantities) result(errors)
      !> The case.
      type(case_type), intent(in) :: c
      !> Number of the argument.
      integer, intent(in) :: j
      !> Results.
      real(wp), intent(in) :: results(max_results)
      !> Number of quantities.
      integer, intent(in) :: n_quantities
      real(wp) :: errors(n_quantities)
      real(qp) :: differences(max_results)

      associate (reference => c%reference(:, j))
         differences = abs(real(results, qp) - reference)
         select case (c%kernel)
         case (kernel_wrench, kernel_jacobian)
            errors(1) = real(maxval(differences(1:2)), wp)
            errors(2) = real(differences(3), wp)
            errors(3) = real(differences(3)/abs(reference(3)), wp)
            if (c%kernel == kernel_jacobian) then
               errors(4) = real(maxval(differences(4:))/maxval(abs(reference(4:))), wp)
            end if
         case default
            ! In units in the last place of the rounded reference.
            associate (exact => reference(:n_quantities))
               errors = real(differences(:n_quantities)/real(spacing(real(exact, wp)), qp), wp)
            end associate
         end select
      end associate
   end function errors_of

   !> Sort a list in rising order.
   pure subroutine sort(x)
      !> The list.
      real(wp), intent(inout) :: x(:)
      real(wp) :: item
      integer :: gap, i, j

      gap = size(x)
      do while (gap > 1)
         gap = max(1, int(0.45_wp*gap))
         do i = gap + 1, size(x)
            item = x(i)
            j = i - gap
            do while (j >= 1)
               if (x(j) <= item) exit
               x(j + gap) = x(j)
               j = j - gap
            end do
            x(j + gap) = item
         end do
      end do
   end subroutine sort

   !> Time all rungs in turn, again and again; of each the shortest batch counts.
   subroutine measure_times(suite, duration, rounds)
      !> The suite.
      type(suite_type), intent(inout), target :: suite
      !> Time after which no round begins [s].
      real(wp), intent(in) :: duration
      !> Number of rounds.
      integer, intent(out) :: rounds
      real(wp) :: start, pass_time
      integer :: i, mode
      logical :: slow(2, size(suite%rungs))

      ! What a pass takes, the second time: the first one loads tables and libraries.
      do i = 1, size(suite%rungs)
         do mode = 1, 2
            associate (rung => suite%rungs(i))
               call time_batch(rung, suite%cases(rung%place), mode, pass_time)
               call time_batch(rung, suite%cases(rung%place), mode, pass_time)
               slow(mode, i) = pass_time > slow_pass
               rung%passes(mode) = max(1, ceiling(batch_time/max(pass_time, 1.0e-9_wp)))
            end associate
         end do
      end do
      start = wall_seconds()
      rounds = 0
      do
         do i = 1, size(suite%rungs)
            do mode = 1, 2
               associate (rung => suite%rungs(i))
                  if (slow(mode, i) .and. mod(rounds, slow_stride) /= 0) cycle
                  call time_batch(rung, suite%cases(rung%place), mode, pass_time)
                  rung%seconds(mode) = min(rung%seconds(mode), pass_time/n_arguments)
               end associate
            end do
         end do
         rounds = rounds + 1
         if (wall_seconds() - start > duration) exit
      end do
   end subroutine measure_times

   !> Time a batch.
   subroutine time_batch(rung, c, mode, pass_time)
      !> The rung.
      type(rung_type), intent(in) :: rung
      !> Its case.
      type(case_type), intent(in) :: c
      !> 1 for throughput, 2 for a chain.
      integer, intent(in) :: mode
      !> Time of a pass [s].
      real(wp), intent(out) :: pass_time
      real(wp) :: start
      integer :: i

      start = wall_seconds()
      do i = 1, rung%passes(mode)
         if (mode == 1) then
            call pass_in_throughput(rung, c)
         else
            call pass_in_chain(rung, c)
         end if
      end do
      pass_time = (wall_seconds() - start)/rung%passes(mode)
   end subroutine time_batch

   !> Call a rung for all arguments; no call waits for another.
   subroutine pass_in_throughput(rung, c)
      !> The rung.
      type(rung_type), intent(in) :: rung
      !> Its case.
      type(case_type), intent(in) :: c
      real(wp) :: total, r(6), wrench(3), jacobian(3, 3)
      integer :: i
      logical :: found

      total = 0.0_wp
      associate (x => c%arguments)
         select case (rung%way)
         case (way_log)
            do i = 1, n_arguments
               total = total + log(x(1, i))
            end do
         case (way_elliptic)
            do i = 1, n_arguments
               call rung%elliptic(x(1, i), r(1), r(2), r(3), r(4), r(5), r(6))
            end do
            total = r(1)
         case (way_tables_ke)
            do i = 1, n_arguments
               call complete_elliptic(x(1, i), r(1), r(2))
               total = total + (r(1) + r(2))
            end do
         case (way_boost_ke)
            do i = 1, n_arguments
               call boost_ke(x(1, i), r(1), r(2))
               total = total + (r(1) + r(2))
            end do
         case (way_gsl_ke)
            do i = 1, n_arguments
               call gsl_complete_ke(sqrt(1.0_wp - x(1, i)), r(1), r(2), found)
               total = total + (r(1) + r(2))
            end do
         case (way_hertz)
            do i = 1, n_arguments
               call rung%hertz(x(1, i), x(2, i), x(3, i), x(4, i), r(1), r(2), r(3), r(4), r(5))
            end do
            total = r(4)
         case (way_fixed_hertz)
            do i = 1, n_arguments
               call c%contacts(i)%contact(x(4, i), r(2), r(3), r(4), r(5))
               total = total + ((r(2) + r(3)) + (r(4) + r(5)))
            end do
         case (way_wrench)
            do i = 1, n_arguments
               call rung%wrench(c%shape, x(1, i), x(2, i), x(3, i), 0.0_wp, .true., wrench(1), &
                  wrench(2), wrench(3))
            end do
            total = wrench(1)
         case default
            do i = 1, n_arguments
               call rung%jacobian(c%shape, x(1, i), x(2, i), x(3, i), 0.0_wp, wrench, jacobian)
            end do
            total = jacobian(1, 1)
         end select
      end associate
      sink = total
   end subroutine pass_in_throughput

   !> Call a rung for all arguments; each call waits for the results of the one before.
   subroutine pass_in_chain(rung, c)
      !> The rung.
      type(rung_type), intent(in) :: rung
      !> Its case.
      type(case_type), intent(in) :: c
      real(wp) :: r(6), wrench(3), jacobian(3, 3)
      integer(i8) :: mask
      integer :: i
      logical :: found

      mask = no_bits
      r = 0.0_wp
      wrench = 0.0_wp
      jacobian = 0.0_wp
      associate (x => c%arguments)
         select case (rung%way)
         case (way_log)
            do i = 1, n_arguments
               r(1) = log(tied(x(1, i), r(1), r(1), mask))
            end do
         case (way_elliptic)
            do i = 1, n_arguments
               call rung%elliptic(tied(x(1, i), r(2), r(5), mask), r(1), r(2), r(3), r(4), r(5), &
                  r(6))
            end do
         case (way_tables_ke)
            do i = 1, n_arguments
               call complete_elliptic(tied(x(1, i), r(1), r(2), mask), r(1), r(2))
            end do
         case (way_boost_ke)
            do i = 1, n_arguments
               call boost_ke(tied(x(1, i), r(1), r(2), mask), r(1), r(2))
            end do
         case (way_gsl_ke)
            do i = 1, n_arguments
               call gsl_complete_ke(sqrt(1.0_wp - tied(x(1, i), r(1), r(2), mask)), r(1), r(2), &
                  found)
            end do
         case (way_hertz)
            do i = 1, n_arguments
               call rung%hertz(tied(x(1, i), r(4), r(5), mask), x(2, i), x(3, i), x(4, i), r(1), &
                  r(2), r(3), r(4), r(5))
            end do
         case (way_fixed_hertz)
            do i = 1, n_arguments
               call c%contacts(i)%contact(tied(x(4, i), r(4), r(5), mask), r(2), r(3), r(4), r(5))
            end do
         case (way_wrench)
            do i = 1, n_arguments
               call rung%wrench(c%shape, tied(x(1, i), wrench(1), wrench(3), mask), x(2, i), &
                  x(3, i), 0.0_wp, .true., wrench(1), wrench(2), wrench(3))
            end do
         case default
            do i = 1, n_arguments
               call rung%jacobian(c%shape, tied(x(1, i), wrench(1), jacobian(3, 3), mask), &
                  x(2, i), x(3, i), 0.0_wp, wrench, jacobian)
            end do
         end select
      end associate
      sink = r(1) + wrench(1)
   end subroutine pass_in_chain

   !> A number that is not known before two others are.
   pure function tied(x, first, second, mask) result(y)
      !> The number.
      real(wp), intent(in) :: x
      !> The first of the others.
      real(wp), intent(in) :: first
      !> The second.
      real(wp), intent(in) :: second
      !> Zero.
      integer(i8), intent(in) :: mask
      real(wp) :: y

      y = transfer(ior(transfer(x, 0_i8), iand(ior(transfer(first, 0_i8), &
         transfer(second, 0_i8)), mask)), 0.0_wp)
   end function tied

end module contensou_drivers_bench_rungs
