!> `contensou eval`: evaluate a kernel on a table of inputs.
!>
!> The input is CSV with a header; the columns may stand in any order, and columns that the kernel
!> does not know are passed through. The output repeats the input columns and appends the results
!> with 17 significant digits. Nothing is written when any row has a mistake; rows outside the
!> domain of a kernel give NaN.
module contensou_drivers_eval
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite, ieee_is_nan, ieee_quiet_nan, &
      ieee_value
   use contensou_base_diagnostics, only : diagnostics_type, origin_type, source_type
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : admits, kind_real
   use contensou_base_text, only : did_you_mean, join, lower, quote, strings
   use contensou_contact_catalogue, only : law_keys_type
   use contensou_contact_creep, only : creep_model_type, creep_models, creep_type, default_creep
   use contensou_contact_creep_boundary_elements, only : elements_key, least_elements, most_elements
   use contensou_contact_creep_law, only : creep_spot, passing_type
   use contensou_contact_curved_spot, only : curved_spot_type
   use contensou_contact_kalker, only : kalker_coefficients
   use contensou_contact_friction, only : friction_model_type, friction_models, friction_type
   use contensou_contact_friction_law, only : sliding_type
   use contensou_contact_hertz, only : hertz_kernel, hertz_model_type, hertz_models, &
      hertz_newton_with, hertz_spot_type
   use contensou_contact_parameters, only : parameters_type, surroundings_type
   use contensou_contact_spot, only : circular_shape, elliptic_shape, spot_shape_type
   use contensou_contact_tangential_oblique, only : oblique_impact
   use contensou_contact_tangential_shells, only : default_layers, most_layers, &
      shells_type, single_spring, spring_spot_type
   use contensou_contact_tangential_stiffness, only : tangential_stiffness
   use contensou_contact_vilke, only : vilke_models
   use contensou_contact_wrench_curved, only : coarsest, mapped_only, slender_only
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      takes_count, takes_non_negative
   use contensou_drivers_table, only : digits17, has_column, printer_type, read_lines, read_table
   use contensou_special_elliptic, only : elliptic_kernel, elliptic_model_type, elliptic_models
   implicit none(type, external)
   private

   public :: eval_command

   !> What the user asks for, in the words of the options; texts blank for the default.
   type :: eval_config_type
      character(len=:), allocatable :: kernel, file, model
      real(wp) :: delta = 0.0_wp
      logical :: jacobian = .false.
      !> Bound of the error over f N; zero for the default.
      real(wp) :: error = 0.0_wp
      !> Layers of tangential elasticity; zero for the default.
      integer :: layers = 0
      !> Elements across the spot of boundary elements; zero for the default.
      integer :: elements = 0
   end type eval_config_type

   !> Names of the kernels.
   character(len=*), parameter :: kernels(*) = [character(len=20) :: "elliptic", "hertz", &
      "wrench", "curved_wrench", "kalker", "creep", "tangential", "tangential_stiffness", &
      "oblique_impact"]

   character(len=*), parameter :: nl = new_line("a")

   !> Inputs of the kernel `hertz`.
   character(len=*), parameter :: hertz_inputs(*) = [character(len=5) :: &
      "A", "B", "Estar", "delta"]

   !> Inputs of the kernel `wrench`.
   character(len=*), parameter :: wrench_inputs(*) = [character(len=2) :: &
      "N", "a", "b", "f", "vx", "vy", "w"]

   !> Inputs of the kernel `kalker`.
   character(len=*), parameter :: kalker_inputs(*) = [character(len=8) :: &
      "a_over_b", "nu", "chi"]

   !> Inputs of the kernel `creep`.
   character(len=*), parameter :: creep_inputs(*) = [character(len=2) :: &
      "N", "a", "b", "f", "G", "nu", "vx", "vy", "w", "cx", "cy"]

   !> Inputs of the kernel `curved_wrench`, and what it gives.
   character(len=*), parameter :: curved_inputs(*) = [character(len=3) :: &
      "N", "a", "b", "f", "Lxx", "Lxy", "Lyy", "vx", "vy", "w", "wx", "wy"]
   character(len=*), parameter :: curved_outputs = "Fx,Fy,Tz,Mx,My"
   character(len=*), parameter :: curved_slopes = "dFxdvx,dFxdvy,dFxdw,dFxdwx,dFxdwy," // &
      "dFydvx,dFydvy,dFydw,dFydwx,dFydwy,dTzdvx,dTzdvy,dTzdw,dTzdwx,dTzdwy," // &
      "dMxdvx,dMxdvy,dMxdw,dMxdwx,dMxdwy,dMydvx,dMydvy,dMydw,dMydwx,dMydwy"

   !> Inputs of the kernel `tangential`.
   character(len=*), parameter :: tangential_inputs(*) = [character(len=5) :: &
      "N", "a", "b", "f", "G", "nu", "dx", "dy", "twist"]

   !> Inputs of the kernel `tangential_stiffness`.
   character(len=*), parameter :: stiffness_inputs(*) = [character(len=2) :: "a", "b", "G", "nu"]

   !> Inputs of the kernel `oblique_impact`.
   character(len=*), parameter :: oblique_inputs(*) = [character(len=4) :: "nu", "psi1"]

   !> Inputs that must not be negative: as many as the first ones of a kernel.
   integer, parameter :: wrench_magnitudes = 4, creep_magnitudes = 6, stiffness_magnitudes = 3
   integer, parameter :: kalker_magnitudes = 2, history_magnitudes = 5

   !> What is evaluated for each row.
   type :: evaluation_type
      !> Elliptic integrals.
      procedure(elliptic_kernel), pointer, nopass :: elliptic => null()
      !> Whether the input is c, not c1.
      logical :: of_c = .false.
      !> Normal contact.
      procedure(hertz_kernel), pointer, nopass :: hertz => null()
      !> Elliptic integrals for Newton's method; not associated for another model.
      procedure(elliptic_kernel), pointer, nopass :: integrals => null()
      !> Friction model; not allocated for another kernel.
      type(friction_model_type), allocatable :: friction
      !> Values of its keys that are the same in all rows.
      type(parameters_type) :: parameters
      !> Whether the derivatives of friction are wanted.
      logical :: jacobian = .false.
      !> Whether the kernel is `kalker`.
      logical :: kalker = .false.
      !> Law of creep; not allocated for another kernel.
      class(creep_type), allocatable :: creep
      !> Whether the spot is curved, the bound of its error, and its regularisation velocity.
      logical :: curved = .false.
      real(wp) :: error = 1.0e-10_wp, delta = 0.0_wp
      !> Which of the kernels of tangential elasticity; blank for another one.
      character(len=20) :: tangential = ""
      !> What the spot remembers from the rows before; without a contact for `oblique_impact`.
      type(shells_type) :: shells
      !> Whether the major axis of this spot is y.
      logical :: turned = .false.
      !> Shift and twist of the row before.
      real(wp) :: position(3) = 0.0_wp
      !> Energy lost up to now [J].
      real(wp) :: lost = 0.0_wp
      !> How many of the first inputs must not be negative, and what a message calls them.
      integer :: magnitudes = 0
      character(len=24) :: magnitude_names = ""
      !> Inputs beyond `wrench_inputs`: the keys that the friction model alone has.
      character(len=28), allocatable :: keys(:)
   end type evaluation_type

contains

   !> `contensou eval` in the table of commands.
   function eval_command() result(command)
      type(command_type) :: command

      command = command_type("eval", "evaluate a kernel on a table of inputs", eval_options(), &
         notes= &
         "KERNEL    inputs             outputs              models, the default first" // nl // &
         "elliptic  c1 (or c)          K,E,B,D,dKdc,dEdc    tables, theta, agm, gsl" // nl // &
         "hertz     A,B,Estar,delta    c,c1,a,b,N,p0        hertz (= tables), newton, " // &
         "brewe_hamrock," // nl // &
         "                                                  greenwood, vilke (= vilke_chord)," // &
         nl // &
         "                                                  vilke_power, vilke_exact, newton_agm," &
         // nl // &
         "                                                  newton_gsl, newton_theta" // nl // &
         "wrench    N,a,b,f,vx,vy,w    Fx,Fy,Tz             contensou_exact, coulomb, pade11," // &
         nl // "                                                  pade22, contensou_simplified" // &
         nl // &
         "curved_wrench  N,a,b,f,Lxx,Lxy,Lyy,vx,vy,w,wx,wy  to Fx,Fy,Tz,Mx,My   adaptive, " // &
         "mapped, slender, product" // nl // &
         "creep     N,a,b,f,G,nu,vx,vy,w,cx,cy  to Fx,Fy,Tz   table, sliding," // nl // &
         "                                                  linear, strip, polach," // nl // &
         "                                                  fastsim, brush," // nl // &
         "                                                  boundary_elements" // nl // &
         "kalker                a_over_b,nu,chi  to C11,C12,C22,C13,C23,C33   table;" // nl // &
         "   chi [deg] from the axis a to the rolling direction" // nl // &
         "tangential            N,a,b,f,G,nu,dx,dy,twist   shells, spring" // nl // &
         "   to Fx,Fy,Tz,stored_energy,slip_work; the rows are a history, dx, dy and twist are" // &
         nl // "   where body 1 stands, from the unstrained contact on" // nl // &
         "tangential_stiffness  a,b,G,nu  to kx,ky,kT       mindlin" // nl // &
         "oblique_impact        nu,psi1   to psi2           shells, spring", &
         execute=evaluate_kernel)
   end function eval_command

   !> What the command takes.
   function eval_options() result(options)
      type(option_type), allocatable :: options(:)

      options = [ &
         option_type("KERNEL", "", "elliptic, hertz, wrench, curved_wrench, kalker, creep, " // &
         "tangential, tangential_stiffness or oblique_impact", needs="a kernel", &
         choices="elliptic hertz wrench curved_wrench kalker creep tangential " // &
         "tangential_stiffness oblique_impact"), &
         option_type("FILE", "", "CSV with a header; standard input if not given"), &
         option_type("--model", "NAME", "how the kernel is computed"), &
         option_type("--delta", "VELOCITY", &
         "regularisation velocity of the wrench [m/s], default 0", needs="a velocity >= 0 [m/s]", &
         takes=takes_non_negative), &
         option_type("--jacobian", "", "the wrench's derivatives, too: dFxdvx ... dTzdw"), &
         option_type("--error", "BOUND", &
         "bound of the error of curved_wrench over f N, default 1e-10", &
         needs="a number >= 0", takes=takes_non_negative), &
         option_type("--layers", "N", &
         "layers of tangential and oblique_impact, 1 to " // to_text(most_layers) // &
         ", default " // to_text(default_layers), &
         needs="a number of layers from 1 to " // to_text(most_layers), takes=takes_count), &
         option_type("--elements", "N", &
         "elements across the spot of boundary_elements, even, 4 to 96, default 36", &
         needs="an even number of elements from 4 to 96", takes=takes_count)]
   end function eval_options

   !> Evaluate a kernel for each row of a table of its inputs.
   subroutine evaluate_kernel(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is a mistake in the input.
      type(error_type), allocatable, intent(out) :: error
      type(eval_config_type) :: config
      type(evaluation_type) :: evaluation
      type(source_type) :: table
      character(len=28), allocatable :: inputs(:)
      integer :: i, k

      call read_config(line, config, i, error)
      if (allocated(error)) return
      select case (kernels(i))
      case ("elliptic")
         call choose_elliptic(config, evaluation, error)
      case ("hertz")
         call choose_hertz(config, evaluation, error)
      case ("wrench")
         call choose_wrench(config, evaluation, error)
      case ("kalker")
         call choose_kalker(config, evaluation, error)
      case ("creep")
         call choose_creep(config, evaluation, error)
      case ("curved_wrench")
         call choose_curved(config, evaluation, error)
      case default
         call choose_tangential(config, trim(kernels(i)), evaluation, error)
      end select
      if (allocated(error)) return
      call read_lines(config%file, table, error)
      if (allocated(error)) return
      select case (kernels(i))
      case ("elliptic")
         evaluation%of_c = has_column(table, "c") .and. .not. has_column(table, "c1")
         if (evaluation%of_c) then
            call evaluate(table, ["c "], "K,E,B,D,dKdc,dEdc", 6, evaluation, error)
         else
            call evaluate(table, ["c1"], "K,E,B,D,dKdc,dEdc", 6, evaluation, error)
         end if
      case ("hertz")
         call evaluate(table, hertz_inputs, "c,c1,a,b,N,p0", 6, evaluation, error)
      case ("kalker")
         call evaluate(table, kalker_inputs, "C11,C12,C22,C13,C23,C33", 6, evaluation, error)
      case ("creep")
         call evaluate(table, creep_inputs, "Fx,Fy,Tz", 3, evaluation, error)
      case ("curved_wrench")
         if (config%jacobian) then
            call evaluate(table, curved_inputs, curved_outputs // "," // curved_slopes, 30, &
               evaluation, error)
         else
            call evaluate(table, curved_inputs, curved_outputs, 5, evaluation, error)
         end if
      case ("tangential")
         call evaluate(table, tangential_inputs, "Fx,Fy,Tz,stored_energy,slip_work", 5, &
            evaluation, error)
      case ("tangential_stiffness")
         call evaluate(table, stiffness_inputs, "kx,ky,kT", 3, evaluation, error)
      case ("oblique_impact")
         call evaluate(table, oblique_inputs, "psi2", 1, evaluation, error)
      case default
         inputs = [character(len=28) :: wrench_inputs, pack(evaluation%keys, &
            [(has_column(table, trim(evaluation%keys(k))) .or. &
            .not. evaluation%parameters%has(trim(evaluation%keys(k))), &
            k=1, size(evaluation%keys))])]
         if (config%jacobian) then
            call evaluate(table, inputs, "Fx,Fy,Tz,dFxdvx,dFxdvy,dFxdw,dFydvx,dFydvy," // &
               "dFydw,dTzdvx,dTzdvy,dTzdw", 12, evaluation, error)
         else
            call evaluate(table, inputs, "Fx,Fy,Tz", 3, evaluation, error)
         end if
      end select
   end subroutine evaluate_kernel

   !> What the command line says; options that do not go with the kernel are refused.
   subroutine read_config(line, config, kernel, error)
      type(command_line_type), intent(in) :: line
      type(eval_config_type), intent(inout) :: config
      !> Position of the kernel among `kernels`.
      integer, intent(out) :: kernel
      !> Set when there is a mistake in it.
      type(error_type), allocatable, intent(out) :: error

      config%kernel = line%text("KERNEL")
      config%file = line%text("FILE")
      config%model = line%text("--model")
      config%delta = line%number("--delta", config%delta)
      config%jacobian = line%has("--jacobian")
      config%error = line%number("--error", config%error)
      config%layers = nint(line%number("--layers", 0.0_wp))
      config%elements = nint(line%number("--elements", 0.0_wp))

      kernel = findloc(kernels == lower(config%kernel), .true., dim=1)
      if (kernel == 0) then
         call fatal(error, "unknown kernel " // quote(config%kernel) // did_you_mean( &
            config%kernel, kernels, "possible are " // join(strings(kernels), ", ")), &
            status_usage)
         return
      end if
      if (all(kernels(kernel) /= ["wrench       ", "curved_wrench"]) .and. &
         (config%delta > 0.0_wp .or. config%jacobian)) then
         call fatal(error, "--delta and --jacobian go with the kernels wrench and curved_wrench", &
            status_usage)
         return
      end if
      if (config%error > 0.0_wp .and. kernels(kernel) /= "curved_wrench") then
         call fatal(error, "--error goes with the kernel curved_wrench", status_usage)
         return
      end if
      if (config%layers > 0 .and. all(kernels(kernel) /= ["tangential    ", "oblique_impact"])) then
         call fatal(error, "--layers goes with the kernels tangential and oblique_impact", &
            status_usage)
         return
      end if
      if (config%elements > 0 .and. kernels(kernel) /= "creep") then
         call fatal(error, "--elements goes with the kernel creep", status_usage)
      end if
   end subroutine read_config

   !> Choose a way to compute the elliptic integrals.
   subroutine choose_elliptic(config, evaluation, error)
      type(eval_config_type), intent(in) :: config
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is no such way.
      type(error_type), allocatable, intent(out) :: error
      type(elliptic_model_type), allocatable :: models(:)
      integer :: i

      models = elliptic_models()
      call choose("elliptic integrals", config%model, "tables", models%name, i, error)
      if (allocated(error)) return
      evaluation%elliptic => models(i)%kernel
   end subroutine choose_elliptic

   !> Choose a model of the normal contact.
   subroutine choose_hertz(config, evaluation, error)
      type(eval_config_type), intent(in) :: config
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is no such model.
      type(error_type), allocatable, intent(out) :: error
      type(hertz_model_type), allocatable :: models(:), volumetric(:)
      type(elliptic_model_type), allocatable :: integrals(:)
      character(len=24), allocatable :: names(:)
      integer :: i, n, m

      models = hertz_models()
      volumetric = vilke_models()
      integrals = elliptic_models()
      n = size(models)
      m = n + size(volumetric)
      allocate(names(m + size(integrals) + 2))
      names(:n) = models%info%name
      do i = 1, size(integrals)
         names(m + i) = "newton_" // trim(integrals(i)%name)
      end do
      do i = 1, size(volumetric)
         names(n + i) = "vilke_" // trim(volumetric(i)%info%name)
      end do
      ! The default of each family: the exact tables, and the chord that the paper uses.
      names(size(names) - 1) = "hertz"
      names(size(names)) = "vilke"
      call choose("normal model", config%model, "hertz", names, i, error)
      if (allocated(error)) return
      if (names(i) == "hertz") i = findloc(names == "tables", .true., dim=1)
      if (names(i) == "vilke") i = findloc(names == "vilke_chord", .true., dim=1)
      if (i <= n) then
         evaluation%hertz => models(i)%kernel
      else if (i <= m) then
         evaluation%hertz => volumetric(i - n)%kernel
      else
         evaluation%hertz => models(1)%kernel
         evaluation%integrals => integrals(i - m)%kernel
      end if
   end subroutine choose_hertz

   !> Choose a friction model.
   subroutine choose_wrench(config, evaluation, error)
      type(eval_config_type), intent(in) :: config
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is no such model.
      type(error_type), allocatable, intent(out) :: error
      type(friction_model_type), allocatable :: models(:)
      type(law_keys_type) :: keys
      integer :: i, k

      models = friction_models()
      ! The first entry, none, has nothing to evaluate.
      call choose("friction model", config%model, "contensou_exact", models(2:)%info%name, i, &
         error)
      if (allocated(error)) return
      evaluation%friction = models(i + 1)
      evaluation%jacobian = config%jacobian
      evaluation%magnitudes = wrench_magnitudes
      evaluation%magnitude_names = "N, a, b and f"
      call evaluation%parameters%set("regularization_velocity", config%delta)
      evaluation%parameters = models(i + 1)%completed(evaluation%parameters)
      keys = models(i + 1)%keys()
      k = keys%at("regularization_velocity")
      if (k > 0) then
         if (.not. admits(keys%keys(k)%key, config%delta)) call fatal(error, "friction model " // &
            quote(trim(models(i + 1)%info%name)) // &
            " needs --delta VELOCITY, a number > 0 [m/s]", status_usage)
      end if
      evaluation%keys = pack(keys%keys(:keys%n)%key%name, keys%keys(:keys%n)%key%kind == kind_real &
         .and. keys%keys(:keys%n)%key%name /= "friction_coefficient" &
         .and. keys%keys(:keys%n)%key%name /= "regularization_velocity")
   end subroutine choose_wrench

   !> There is one way to Kalker's coefficients.
   subroutine choose_kalker(config, evaluation, error)
      type(eval_config_type), intent(in) :: config
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when another one is asked for.
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      call choose("model of the linear theory", config%model, "table", ["table"], i, error)
      if (allocated(error)) return
      evaluation%kalker = .true.
      evaluation%magnitudes = kalker_magnitudes
      evaluation%magnitude_names = "a_over_b and nu"
   end subroutine choose_kalker

   !> Choose a law of creep.
   subroutine choose_creep(config, evaluation, error)
      type(eval_config_type), intent(in) :: config
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is no such law.
      type(error_type), allocatable, intent(out) :: error
      type(creep_model_type), allocatable :: models(:)
      integer :: i

      models = creep_models()
      call choose("law of creep", config%model, default_creep, models%info%name, i, error)
      if (allocated(error)) return
      evaluation%magnitudes = creep_magnitudes
      evaluation%magnitude_names = "N, a, b, f, G and nu"
      if (config%elements > 0) then
         if (models(i)%info%name /= "boundary_elements") then
            call fatal(error, "--elements goes with the model boundary_elements", status_usage)
            return
         else if (config%elements < least_elements .or. config%elements > most_elements .or. &
            mod(config%elements, 2) /= 0) then
            call fatal(error, "--elements needs an even number of elements from 4 to 96", &
               status_usage)
            return
         end if
         call evaluation%parameters%set(elements_key, real(config%elements, wp))
      end if
      call models(i)%create(models(i)%completed(evaluation%parameters), evaluation%creep)
   end subroutine choose_creep

   !> Choose a rule for the curved spot.
   subroutine choose_curved(config, evaluation, error)
      type(eval_config_type), intent(in) :: config
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is no such rule.
      type(error_type), allocatable, intent(out) :: error
      !> Bounds that stand for the rules without one.
      real(wp), parameter :: bounds(2:4) = [mapped_only, slender_only, coarsest]
      integer :: i

      call choose("rule", config%model, "adaptive", [character(len=8) :: "adaptive", &
         "mapped", "slender", "product"], i, error)
      if (allocated(error)) return
      evaluation%curved = .true.
      evaluation%jacobian = config%jacobian
      evaluation%delta = config%delta
      evaluation%magnitudes = wrench_magnitudes
      evaluation%magnitude_names = "N, a, b and f"
      if (i > 1) then
         evaluation%error = bounds(i)
         if (config%error > 0.0_wp) call fatal(error, "--error goes with the model adaptive", &
            status_usage)
      else if (config%error >= mapped_only) then
         call fatal(error, "--error needs a number below 1e-3", status_usage)
      else if (config%error > 0.0_wp) then
         evaluation%error = config%error
      end if
   end subroutine choose_curved

   !> Choose a model of tangential elasticity.
   subroutine choose_tangential(config, kernel, evaluation, error)
      type(eval_config_type), intent(in) :: config
      !> Name of the kernel.
      character(len=*), intent(in) :: kernel
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is no such model.
      type(error_type), allocatable, intent(out) :: error
      integer :: i

      evaluation%tangential = kernel
      if (kernel == "tangential") then
         evaluation%magnitudes = history_magnitudes
         evaluation%magnitude_names = "N, a, b, f and G"
      else if (kernel == "tangential_stiffness") then
         evaluation%magnitudes = stiffness_magnitudes
         evaluation%magnitude_names = "a, b and G"
         call choose("model of the stiffness", config%model, "mindlin", ["mindlin"], i, error)
         return
      end if
      call choose("model of tangential elasticity", config%model, "shells", ["shells", "spring"], &
         i, error)
      if (allocated(error)) return
      if (i == 2) then
         evaluation%shells = single_spring()
         if (config%layers > 0) call fatal(error, "--layers goes with the model shells", &
            status_usage)
      else if (config%layers > most_layers) then
         call fatal(error, "--layers needs a number of layers from 1 to " // &
            to_text(most_layers), status_usage)
      else
         call evaluation%shells%begin(merge(config%layers, default_layers, config%layers > 0))
      end if
   end subroutine choose_tangential

   !> Find a name in a list.
   subroutine choose(what, wanted, default, names, index, error)
      !> What is looked for, for messages.
      character(len=*), intent(in) :: what
      !> The name; blank for the default.
      character(len=*), intent(in) :: wanted
      character(len=*), intent(in) :: default
      character(len=*), intent(in) :: names(:)
      !> Position in the list.
      integer, intent(out) :: index
      !> Set when it is not there.
      type(error_type), allocatable, intent(out) :: error

      index = findloc(names == lower(wanted), .true., dim=1)
      if (wanted == "") index = findloc(names == default, .true., dim=1)
      if (index == 0) call fatal(error, "unknown " // what // " " // quote(wanted) // &
         did_you_mean(wanted, names, "possible are " // join(strings(names), ", ")), status_usage)
   end subroutine choose

   !> Evaluate all rows of a table.
   subroutine evaluate(table, names, header, n_outputs, evaluation, error)
      type(source_type), intent(in) :: table
      !> Names of the inputs.
      character(len=*), intent(in) :: names(:)
      !> Names of the outputs, separated by commas.
      character(len=*), intent(in) :: header
      integer, intent(in) :: n_outputs
      type(evaluation_type), intent(inout) :: evaluation
      !> Set when there is a mistake in the table.
      type(error_type), allocatable, intent(out) :: error
      type(diagnostics_type) :: diagnostics
      type(printer_type), allocatable :: printer
      real(wp), allocatable :: inputs(:, :)
      real(wp) :: outputs(n_outputs)
      integer, allocatable :: lines(:)
      character(len=:), allocatable :: line
      integer :: i, k

      call read_table(table, names, inputs, lines, diagnostics)
      associate (m => evaluation%magnitudes)
         do i = 1, size(lines)
            ! What is not a number gives results that are none; comparing it would trap.
            if (any(ieee_is_nan(inputs(:m, i)))) cycle
            if (any(inputs(:m, i) < 0.0_wp)) call diagnostics%add( &
               origin_type(1, lines(i), 1, len(table%lines(lines(i))%s)), &
               trim(evaluation%magnitude_names) // " must not be negative", "numbers >= 0")
         end do
      end associate
      if (diagnostics%count() > 0) then
         call fatal(error, diagnostics%render([table]) // "nothing was evaluated", status_usage)
         return
      end if
      allocate(printer)
      call printer%put(table%lines(1)%s // "," // header, error)
      do i = 1, size(lines)
         if (allocated(error)) return
         call evaluate_row(evaluation, names, inputs(:, i), outputs)
         line = table%lines(lines(i))%s
         do k = 1, n_outputs
            line = line // "," // digits17(outputs(k))
         end do
         call printer%put(line, error)
      end do
      if (.not. allocated(error)) call printer%flush(error)
   end subroutine evaluate

   subroutine evaluate_row(evaluation, names, x, y)
      type(evaluation_type), intent(inout) :: evaluation
      !> Names of the inputs.
      character(len=*), intent(in) :: names(:)
      !> Inputs.
      real(wp), intent(in) :: x(:)
      !> Outputs.
      real(wp), intent(out) :: y(:)
      type(hertz_spot_type) :: spot
      real(wp) :: c1

      if (associated(evaluation%elliptic)) then
         c1 = x(1)
         if (evaluation%of_c .and. .not. ieee_is_nan(c1)) then
            ! A tiny c outside the domain must not be rounded into it.
            if (c1 >= 0.0_wp .and. c1 <= 1.0_wp) then
               c1 = 1.0_wp - c1
            else
               c1 = ieee_value(c1, ieee_quiet_nan)
            end if
         end if
         call evaluation%elliptic(c1, y(1), y(2), y(3), y(4), y(5), y(6))
      else if (associated(evaluation%integrals)) then
         call hertz_newton_with(evaluation%integrals, x(1), x(2), x(3), x(4), spot)
         y(:6) = [1.0_wp - spot%c1, spot%c1, spot%a, spot%b, spot%force, spot%pressure]
      else if (associated(evaluation%hertz)) then
         call evaluation%hertz(x(1), x(2), x(3), x(4), spot)
         y(:6) = [1.0_wp - spot%c1, spot%c1, spot%a, spot%b, spot%force, spot%pressure]
      else if (evaluation%kalker) then
         y(:6) = kalker_coefficients(x(1), x(2), x(3)*(pi/180.0_wp))
      else if (allocated(evaluation%creep)) then
         call creep_of_row(evaluation%creep, x, y)
      else if (evaluation%curved) then
         call evaluate_curved(evaluation, x, y)
      else if (evaluation%tangential == "tangential") then
         call evaluate_tangential(evaluation, x, y)
      else if (evaluation%tangential == "tangential_stiffness") then
         call stiffness_of_row(x(1), x(2), x(3), x(4), y)
      else if (evaluation%tangential == "oblique_impact") then
         y(1) = oblique_impact(evaluation%shells, x(1), x(2))
      else
         call evaluate_wrench(evaluation, names, x, y)
      end if
   end subroutine evaluate_row

   !> Wrench of a law of creep; the major axis may be either one.
   subroutine creep_of_row(creep, x, wrench)
      class(creep_type), intent(in) :: creep
      !> N, a, b, f, G, nu, vx, vy, w, cx, cy.
      real(wp), intent(in) :: x(:)
      !> Fx, Fy [N], Tz [N m].
      real(wp), intent(out) :: wrench(:)
      type(passing_type) :: at
      real(wp) :: force(3)

      wrench(:3) = ieee_value(wrench, ieee_quiet_nan)
      if (.not. all(ieee_is_finite(x(2:3)))) return
      if (.not. min(x(2), x(3)) > 0.0_wp) return
      at%load = x(1)
      at%a = max(x(2), x(3))
      at%w = x(9)
      if (x(3) > x(2)) then
         at%vx = x(8)
         at%vy = -x(7)
         at%cx = x(11)
         at%cy = -x(10)
      else
         at%vx = x(7)
         at%vy = x(8)
         at%cx = x(10)
         at%cy = x(11)
      end if
      call creep%wrench(creep_spot(shape_of(x(2), x(3)), x(4), x(5), x(6)), at, force)
      if (x(3) > x(2)) force(:2) = [-force(2), force(1)]
      wrench(:3) = force
   end subroutine creep_of_row

   !> Tangential stiffness of a spot whose major axis may be either one.
   subroutine stiffness_of_row(a, b, modulus, poisson, stiffness)
      !> Semi-axes along x and y [m].
      real(wp), intent(in) :: a, b
      !> Shear modulus [Pa].
      real(wp), intent(in) :: modulus
      !> Poisson's ratio.
      real(wp), intent(in) :: poisson
      !> k_x, k_y [N/m] and k_T [N m].
      real(wp), intent(out) :: stiffness(:)
      real(wp) :: k(3)

      k = ieee_value(k, ieee_quiet_nan)
      if (all(ieee_is_finite([a, b]))) then
         if (min(a, b) > 0.0_wp) then
            call tangential_stiffness(shape_of(a, b), max(a, b), modulus, poisson, k)
            if (b > a) k(:2) = k([2, 1])
         end if
      end if
      stiffness(:3) = k
   end subroutine stiffness_of_row

   !> Shape of a spot with finite semi-axes above zero, in any order.
   pure function shape_of(a, b) result(shape)
      real(wp), intent(in) :: a, b
      type(spot_shape_type) :: shape

      shape = circular_shape
      if (abs(a - b) > 0.0_wp) shape = elliptic_shape(min(a, b)/max(a, b))
   end function shape_of

   !> The next row of a history. A row outside the domain gives NaN and is no part of the history.
   subroutine evaluate_tangential(evaluation, x, y)
      type(evaluation_type), intent(inout) :: evaluation
      !> N, a, b, f, G, nu, dx, dy, twist.
      real(wp), intent(in) :: x(:)
      !> Fx, Fy, Tz, stored energy, energy lost from the first row on.
      real(wp), intent(out) :: y(:)
      type(spring_spot_type) :: spot
      real(wp) :: step(3), wrench(3), stored, lost
      logical :: open, turned, valid

      y = ieee_value(y, ieee_quiet_nan)
      valid = all(ieee_is_finite(x(:9)))
      if (valid) valid = x(5) > 0.0_wp .and. x(6) >= -1.0_wp .and. x(6) <= 0.5_wp
      if (.not. valid) return
      open = .not. x(1) > 0.0_wp
      if (.not. (open .or. min(x(2), x(3)) > 0.0_wp)) return
      step = x(7:9) - evaluation%position
      if (open) then
         spot = spring_spot_type(circular_shape, 0.0_wp, 0.0_wp, [0.0_wp, 0.0_wp, 0.0_wp])
      else
         turned = x(3) > x(2)
         spot%shape = shape_of(x(2), x(3))
         if (.not. ieee_is_finite(spot%shape%k)) return
         spot%a = max(x(2), x(3))
         spot%limit = x(4)*x(1)
         call tangential_stiffness(spot%shape, spot%a, x(5), x(6), spot%stiffness)
         if (turned .neqv. evaluation%turned) then
            call evaluation%shells%turn(turned)
            evaluation%turned = turned
         end if
         if (turned) step(:2) = [step(2), -step(1)]
      end if
      evaluation%position = x(7:9)
      call evaluation%shells%advance(spot, step, wrench, stored, lost)
      evaluation%lost = evaluation%lost + lost
      if (evaluation%turned) wrench(:2) = [-wrench(2), wrench(1)]
      y(:5) = [wrench, stored, evaluation%lost]
   end subroutine evaluate_tangential

   !> Friction of a curved spot; the major axis may be either one.
   subroutine evaluate_curved(evaluation, x, y)
      type(evaluation_type), intent(in) :: evaluation
      !> N, a, b, f, Lxx, Lxy, Lyy, vx, vy, w, wx, wy.
      real(wp), intent(in) :: x(:)
      !> Fx, Fy, Tz, Mx, My, and row by row their derivatives by vx, vy, w, wx, wy if they are
      !> wanted.
      real(wp), intent(out) :: y(:)
      type(curved_spot_type) :: spot
      type(sliding_type) :: slides
      type(spot_shape_type) :: shape
      real(wp) :: rolling(2), values(5), slopes(5, 7), jacobian(5, 5), turn(5, 5)
      logical :: swapped

      y = ieee_value(y, ieee_quiet_nan)
      if (.not. all(ieee_is_finite(x(:12)))) return
      if (.not. min(x(2), x(3)) > 0.0_wp) return
      swapped = x(3) > x(2)
      shape = shape_of(x(2), x(3))
      spot = curved_spot_type(evaluation%error, 0.0_wp, x(4), evaluation%delta, x(5:7))
      slides = sliding_type(x(1), max(x(2), x(3)), x(8), x(9), x(10))
      rolling = x(11:12)
      turn = 0.0_wp
      turn(3, 3) = 1.0_wp
      if (swapped) then
         spot%form = [x(7), -x(6), x(5)]
         slides%vx = x(9)
         slides%vy = -x(8)
         rolling = [x(12), -x(11)]
         turn(1, 2) = -1.0_wp
         turn(2, 1) = 1.0_wp
      else
         turn(1, 1) = 1.0_wp
         turn(2, 2) = 1.0_wp
      end if
      turn(4:5, 4:5) = turn(1:2, 1:2)
      if (evaluation%jacobian) then
         call spot%linearize(shape, slides, rolling, values, slopes)
         jacobian = matmul(turn, matmul(slopes(:, 3:), transpose(turn)))
         y(6:30) = reshape(transpose(jacobian), [25])
      else
         call spot%wrench(shape, slides, rolling, values(1:3), values(4:5))
      end if
      y(1:5) = matmul(turn, values)
   end subroutine evaluate_curved

   !> Friction wrench of a row; the major axis may be either one.
   subroutine evaluate_wrench(evaluation, names, x, y)
      type(evaluation_type), intent(in) :: evaluation
      !> Names of the inputs.
      character(len=*), intent(in) :: names(:)
      !> N, a, b, f, vx, vy, w, and values of keys of the model.
      real(wp), intent(in) :: x(:)
      !> Fx, Fy, Tz, and row by row their derivatives by vx, vy, w if they are wanted.
      real(wp), intent(out) :: y(:)
      !> From axes whose x axis is the minor axis of the spot to those whose y axis is.
      real(wp), parameter :: turn(3, 3) = reshape([0.0_wp, -1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      class(friction_type), allocatable :: friction
      type(parameters_type) :: parameters
      type(sliding_type) :: slides
      type(spot_shape_type) :: shape
      real(wp) :: minor, major, motion(3), wrench(3), jacobian(3, 3), slopes(3, 5)
      logical :: swapped
      integer :: i

      parameters = evaluation%parameters
      call parameters%set("friction_coefficient", x(4))
      do i = size(wrench_inputs) + 1, size(names)
         call parameters%set(trim(names(i)), x(i))
      end do
      call evaluation%friction%create(parameters, surroundings_type(), friction)
      shape = circular_shape
      swapped = .false.
      if (any(ieee_is_nan(x(2:3)))) then
         shape = elliptic_shape(ieee_value(minor, ieee_quiet_nan))
      else
         swapped = x(3) > x(2)
         minor = min(x(2), x(3))
         if (minor < max(x(2), x(3))) shape = elliptic_shape(minor/max(x(2), x(3)))
      end if
      motion = x(5:7)
      major = x(2)
      if (swapped) then
         motion = matmul(turn, motion)
         major = x(3)
      end if
      slides = sliding_type(x(1), major, motion(1), motion(2), motion(3))
      call friction%wrench(shape, slides, wrench)
      if (swapped) wrench = matmul(wrench, turn)
      y(:3) = wrench
      if (.not. evaluation%jacobian) return
      call friction%linearize(shape, slides, wrench, slopes)
      jacobian = slopes(:, 3:5)
      if (swapped) jacobian = matmul(transpose(turn), matmul(jacobian, turn))
      y(4:12) = reshape(transpose(jacobian), [9])
   end subroutine evaluate_wrench

end module contensou_drivers_eval
