!> What there is to measure for `contensou bench kernels`: cases (sets of arguments) and rungs (ways
!> to compute) on them.
module contensou_drivers_bench_suite
   use contensou_base_kinds, only : i8, pi, wp
   use contensou_base_numbers, only : to_text
   use contensou_contact_creep, only : creep_model_type, creep_models, creep_type, &
      default_creep
   use contensou_contact_creep_boundary_elements, only : elements_key
   use contensou_contact_creep_law, only : creep_motion_type, creep_spot, creep_spot_type, &
      settled_spot
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_hertz, only : hertz_kernel, hertz_model_type, hertz_models, hertz_type, &
      new_hertz
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_spot, only : elliptic_shape, spot_shape_type
   use contensou_contact_vilke, only : vilke_models
   use contensou_contact_wrench, only : wrench_exact, wrench_exact_jacobian, &
      wrench_jacobian_kernel, wrench_kernel, wrench_simplified_jacobian
   use contensou_drivers_bench_baselines, only : boost_version, elliptic_boost, newton_agm, &
      newton_gsl
   use contensou_drivers_bench_curved, only : curved_10, curved_4, curved_6, curved_mapped, &
      curved_product, curved_slender, slip_by_rolling
   use contensou_drivers_bench_reference, only : qp
   use contensou_drivers_bench_tangential, only : layers_of_rungs, rung_name
   use contensou_special_elliptic, only : elliptic_kernel, elliptic_model_type, elliptic_models
   implicit none(type, external)
   private

   public :: suite_type, case_type, rung_type, new_suite, motion_of
   public :: name_length, kernel_names, n_arguments, max_quantities, max_results
   public :: kernel_log, kernel_elliptic, kernel_ke, kernel_hertz, kernel_wrench, kernel_jacobian, &
      kernel_curved, kernel_creep, kernel_creep_jacobian, kernel_tangential
   public :: way_log, way_elliptic, way_tables_ke, way_boost_ke, way_gsl_ke, way_hertz, &
      way_fixed_hertz, way_wrench, way_jacobian, way_creep, way_creep_jacobian, way_tangential

   integer, parameter :: name_length = 20

   integer, parameter :: kernel_log = 1, kernel_elliptic = 2, kernel_ke = 3, kernel_hertz = 4, &
      kernel_wrench = 5, kernel_jacobian = 6, kernel_curved = 7, kernel_creep = 8, &
      kernel_creep_jacobian = 9, kernel_tangential = 10

   !> Their names.
   character(len=*), parameter :: kernel_names(10) = [character(len=name_length) :: "log", &
      "elliptic", "elliptic_ke", "hertz", "wrench", "wrench_jacobian", "curved_wrench", "creep", &
      "creep_jacobian", "tangential"]

   !> How a rung is called.
   integer, parameter :: way_log = 1, way_elliptic = 2, way_tables_ke = 3, way_boost_ke = 4, &
      way_gsl_ke = 5, way_hertz = 6, way_fixed_hertz = 7, way_wrench = 8, way_jacobian = 9, &
      way_creep = 10, way_creep_jacobian = 11, way_tangential = 12

   !> Arguments in a case.
   integer, parameter :: n_arguments = 2048

   !> Largest number of quantities that a kernel computes.
   integer, parameter :: max_quantities = 6

   !> Largest number of arguments and of results of a kernel.
   integer, parameter :: max_inputs = 4, max_results = 12

   !> The law of creep that is the reference, and elements across the spot of its rungs that have
   !> fewer.
   character(len=*), parameter :: exact_creep = "boundary_elements"
   integer, parameter :: fewer_elements(2) = [8, 16]

   !> Modulus and multiplier of the random numbers (Park and Miller).
   integer(i8), parameter :: random_modulus = 2147483647_i8, random_multiplier = 48271_i8

   !> A law of creep.
   type :: law_type
      class(creep_type), allocatable :: creep
   end type law_type

   !> A set of arguments for a kernel.
   type :: case_type
      integer :: kernel = 0
      character(len=name_length) :: name = ""
      character(len=80) :: title = ""
      !> Arguments, (input, number).
      real(wp) :: arguments(max_inputs, n_arguments) = 0.0_wp
      !> Number of arguments that are compared with the reference.
      integer :: checked = 0
      !> Reference, (result, number).
      real(qp), allocatable :: reference(:, :)
      !> Axis ratio of the spot.
      real(wp) :: ratio = 1.0_wp
      type(spot_shape_type) :: shape
      !> Contacts whose curvatures do not change.
      type(hertz_type), allocatable :: contacts(:)
      !> Spot that rolls, velocity of the material through it times e0, and the laws of creep.
      type(creep_spot_type) :: spot
      real(wp) :: rolling(2) = 0.0_wp
      type(law_type), allocatable :: laws(:)
      !> The law that is the reference, and the time of a call of it [s].
      integer :: reference_law = 0
      real(wp) :: reference_seconds = 0.0_wp
   end type case_type

   !> A way to compute a kernel, on a case.
   type :: rung_type
      character(len=name_length) :: name = ""
      !> Case.
      integer :: place = 0
      !> How it is called.
      integer :: way = 0
      !> Index of a law of creep.
      integer :: law = 0
      !> Whether that law is the reference: it has no error, and is timed as that is made.
      logical :: is_reference = .false.
      !> Whether a call takes so long that it is timed with the arguments that are compared, and in
      !> throughput alone: a wait for the results before is nothing to it.
      logical :: is_long = .false.
      !> Layers of tangential elasticity.
      integer :: layers = 0
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

contains

   !> Everything that is measured, with its arguments.
   subroutine new_suite(suite)
      type(suite_type), intent(out) :: suite
      integer(i8) :: state

      state = 20090921_i8
      allocate(suite%cases(0), suite%rungs(0))
      call add_case(suite, kernel_log, "random", "log x even, 1e-6 to 1e6")
      suite%cases(1)%arguments(1, :) = between(state, 1.0e-6_wp, 1.0e6_wp)
      call add_elliptic(suite, state)
      call add_hertz(suite, state)
      call add_wrench(suite, state)
      call add_curved(suite, state)
      call add_creep(suite, state)
      call add_tangential(suite, state)
      call add_rungs(suite)
   end subroutine new_suite

   subroutine add_case(suite, kernel, name, title)
      type(suite_type), intent(inout) :: suite
      integer, intent(in) :: kernel
      character(len=*), intent(in) :: name
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

   !> A case of a ball that rolls in a groove: b/a = 0.1, sliding and spinning up to 0.6 of the slip
   !> by rolling.
   subroutine add_curved(suite, state)
      type(suite_type), intent(inout) :: suite
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      integer :: i, j

      call add_case(suite, kernel_curved, "groove", &
         "b/a = 0.1, sliding and spinning up to 0.6 of the slip by rolling, even")
      associate (c => suite%cases(size(suite%cases)))
         c%ratio = 0.1_wp
         c%shape = elliptic_shape(c%ratio)
         do j = 1, n_arguments
            do i = 1, 3
               c%arguments(i, j) = 0.6_wp*slip_by_rolling*(2.0_wp*uniform(state) - 1.0_wp)
            end do
         end do
      end associate
   end subroutine add_curved

   !> Cases of the laws of creep, without and with their Jacobian.
   subroutine add_creep(suite, state)
      type(suite_type), intent(inout) :: suite
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      character(len=*), parameter :: names(3) = [character(len=7) :: "no_spin", "spin", "oblique"]
      character(len=*), parameter :: titles(3) = [character(len=60) :: &
         "circle, no spin, log creepage even, 0.1 to 10 e0", &
         "k = 0.5, rolling along the major axis, with spin", &
         "k = 0.5, rolling at 30 degrees, with spin"]
      real(wp) :: creepage, angle
      integer :: n, i, j

      n = size(suite%cases)
      do i = 1, 3
         call add_case(suite, kernel_creep, names(i), titles(i))
         associate (c => suite%cases(n + i))
            ! As in a scene whose curvatures do not vary.
            c%spot = settled_spot(creep_spot(elliptic_shape(merge(1.0_wp, 0.5_wp, i == 1)), &
               0.3_wp, 8.0e10_wp, 0.3_wp))
            c%rolling = -[1.0_wp, 0.0_wp]
            if (i == 3) c%rolling = -[0.5_wp*sqrt(3.0_wp), 0.5_wp]
            do j = 1, n_arguments
               creepage = 10.0_wp**(2.0_wp*uniform(state) - 1.0_wp)
               angle = 2.0_wp*pi*uniform(state)
               c%arguments(1:2, j) = creepage*[cos(angle), sin(angle)]
               if (i > 1) c%arguments(3, j) = creepage*(4.0_wp*uniform(state) - 2.0_wp)
            end do
         end associate
      end do
      do i = n + 1, n + 3
         call add_case(suite, kernel_creep_jacobian, suite%cases(i)%name, suite%cases(i)%title)
         suite%cases(size(suite%cases)) = suite%cases(i)
         suite%cases(size(suite%cases))%kernel = kernel_creep_jacobian
      end do
   end subroutine add_creep

   !> Cases of tangential elasticity: places of a spot one after the other.
   subroutine add_tangential(suite, state)
      type(suite_type), intent(inout) :: suite
      !> State of the random numbers.
      integer(i8), intent(inout) :: state
      character(len=*), parameter :: names(4) = [character(len=12) :: "shift", "shift_k0.5", &
         "twist", "twist_k0.5"]
      character(len=*), parameter :: titles(4) = [character(len=60) :: &
         "circle, shifted to and fro", "k = 0.5, shifted to and fro", &
         "circle, shifted and twisted to and fro", "k = 0.5, shifted and twisted to and fro"]
      !> Share of the way to the next turn in a step.
      real(wp), parameter :: share = 0.1_wp
      real(wp) :: from(3), to(3)
      integer :: i, j, k, n, steps

      n = size(suite%cases)
      steps = nint(1.0_wp/share)
      do i = 1, 4
         call add_case(suite, kernel_tangential, names(i), titles(i))
         associate (c => suite%cases(n + i))
            c%ratio = merge(1.0_wp, 0.5_wp, mod(i, 2) == 1)
            c%shape = elliptic_shape(c%ratio)
            to = 0.0_wp
            do j = 1, n_arguments
               if (mod(j - 1, steps) == 0) then
                  from = to
                  do k = 1, 3
                     to(k) = 2.0_wp*uniform(state) - 1.0_wp
                  end do
                  if (i < 3) to(3) = 0.0_wp
               end if
               c%arguments(1:3, j) = from + (to - from)*(share*(mod(j - 1, steps) + 1))
            end do
         end associate
      end do
   end subroutine add_tangential

   !> Motion of a spot that rolls.
   pure function motion_of(c, x) result(motion)
      type(case_type), intent(in) :: c
      !> Sliding velocity along the axes, and that of the spin.
      real(wp), intent(in) :: x(3)
      type(creep_motion_type) :: motion

      motion = creep_motion_type(x(1), x(2), x(3), c%rolling(1), c%rolling(2))
   end function motion_of

   !> The rungs of every case.
   subroutine add_rungs(suite)
      type(suite_type), intent(inout) :: suite
      type(elliptic_model_type), allocatable :: elliptic(:)
      type(hertz_model_type), allocatable :: hertz(:), vilke(:)
      type(friction_model_type), allocatable :: friction(:)
      type(creep_model_type), allocatable :: creep(:)
      type(rung_type) :: rung
      logical :: with_boost
      integer :: place, i

      elliptic = elliptic_models()
      hertz = hertz_models()
      vilke = vilke_models()
      friction = friction_models()
      creep = creep_models()
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
               call add(elliptic(i)%name, way_elliptic)
            end do
            rung%elliptic => elliptic_boost
            if (with_boost) call add("boost", way_elliptic)
         case (kernel_ke)
            call add("tables", way_tables_ke)
            call add("gsl", way_gsl_ke)
            if (with_boost) call add("boost", way_boost_ke)
         case (kernel_hertz)
            do i = 1, size(hertz)
               rung%hertz => hertz(i)%kernel
               call add(hertz(i)%info%name, way_hertz)
            end do
            rung%hertz => newton_agm
            call add("newton_agm", way_hertz)
            rung%hertz => newton_gsl
            call add("newton_gsl", way_hertz)
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
         case (kernel_curved)
            rung%wrench => curved_10
            call add("within_1e-10", way_wrench)
            rung%wrench => curved_6
            call add("within_1e-6", way_wrench)
            rung%wrench => curved_4
            call add("within_1e-4", way_wrench)
            rung%wrench => curved_mapped
            call add("mapped", way_wrench)
            rung%wrench => curved_slender
            call add("slender", way_wrench)
            rung%wrench => curved_product
            call add("product", way_wrench)
            rung%wrench => wrench_exact
            call add("flat", way_wrench)
         case (kernel_creep, kernel_creep_jacobian)
            call add_laws(suite%cases(place)%kernel == kernel_creep)
         case (kernel_tangential)
            do i = 1, size(layers_of_rungs)
               rung%layers = layers_of_rungs(i)
               call add(rung_name(rung%layers), way_tangential)
            end do
         case default
            rung%jacobian => wrench_simplified_jacobian
            call add("contensou_simplified", way_jacobian)
            rung%jacobian => wrench_exact_jacobian
            call add("contensou_exact", way_jacobian)
         end select
      end do

   contains

      !> Add the laws of creep.
      subroutine add_laws(steady)
         !> Whether their wrenches are wanted, not the derivatives.
         logical, intent(in) :: steady
         integer :: i

         allocate(suite%cases(place)%laws(size(creep) + size(fewer_elements)))
         do i = 1, size(creep)
            call creep(i)%make(suite%cases(place)%laws(i)%creep)
            if (creep(i)%info%name == exact_creep) then
               suite%cases(place)%reference_law = i
               if (steady) call add_elements(i)
            end if
            rung%law = i
            rung%is_reference = creep(i)%info%name == exact_creep
            if (steady) then
               call add(creep(i)%info%name, way_creep)
            else if (creep(i)%info%name == "sliding" .or. creep(i)%info%name == &
               default_creep) then
               call add(creep(i)%info%name, way_creep_jacobian)
            end if
         end do
      end subroutine add_laws

      !> Add boundary elements with fewer elements.
      subroutine add_elements(law)
         !> Index of the law.
         integer, intent(in) :: law
         type(parameters_type) :: parameters
         integer :: i

         rung%is_long = .true.
         do i = 1, size(fewer_elements)
            rung%law = size(creep) + i
            call parameters%set(elements_key, real(fewer_elements(i), wp))
            call creep(law)%create(creep(law)%completed(parameters), &
               suite%cases(place)%laws(rung%law)%creep)
            call add(exact_creep // "_" // to_text(fewer_elements(i)), way_creep)
         end do
         rung%is_long = .false.
      end subroutine add_elements

      !> Add a rung.
      subroutine add(name, way)
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

end module contensou_drivers_bench_suite
