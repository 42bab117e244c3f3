!> What `contensou cost` runs and compares: the keys of the group `cost` and their values.
module contensou_scene_cost
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : key_list_type, kind_choice, kind_integer, kind_real, &
      most_values
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote
   use contensou_contact_parts, only : friction_names, normal_names
   use contensou_contact_tangential_law, only : creep_names
   use contensou_contact_tangential_shells, only : most_layers
   use contensou_integrate_methods, only : integrator_methods
   implicit none(type, external)
   private

   public :: cost_spec_type, cost_quantities, cost_measures, put_cost_keys, build_cost

   !> What the errors of `contensou cost` can be taken of.
   character(len=*), parameter :: cost_quantities(*) = [character(len=16) :: &
      "position", "angle", "velocity", "angular_velocity", "events", "energy"]

   !> Which error of a trajectory counts: the one at the end, the largest, the root mean square.
   character(len=*), parameter :: cost_measures(*) = [character(len=7) :: "end", "largest", "rms"]

   !> What `contensou cost` runs.
   type :: cost_spec_type
      !> Friction models, indices into `friction_models`; empty for those that fit the scene.
      integer, allocatable :: friction(:)
      !> Normal force models, indices into `normal_models`; empty for that of each contact.
      integer, allocatable :: normal(:)
      !> Layers of tangential elasticity, 0 for one spring.
      integer, allocatable :: layers(:)
      !> Laws of creep, indices into `creep_models`; empty for that of each contact.
      integer, allocatable :: creep(:)
      !> Whether the layers were given, and not the default.
      logical :: layers_given = .false.
      character(len=11), allocatable :: methods(:)
      !> Relative tolerances [-].
      real(wp), allocatable :: rtol(:)
      !> Relative tolerance of the reference [-].
      real(wp) :: reference_rtol = 0.0_wp
      !> Which of `cost_quantities` count.
      logical :: counts(size(cost_quantities)) = .false.
      !> Index into `cost_measures`.
      integer :: measure = 0
      !> Times at which trajectories are compared, beside the beginning.
      integer :: samples = 0
      !> Times that a short run is repeated.
      integer :: repeats = 0
      !> Longest run, in CPU times of the reference [-].
      real(wp) :: cpu_limit = 0.0_wp
   end type cost_spec_type

contains

   !> The keys of a study of costs.
   subroutine put_cost_keys(list)
      type(key_list_type), intent(inout) :: list

      call list%put("cost", "friction", kind_choice, choices=friction_names, values=most_values, &
         fewer=.true., &
         doc="friction models that are compared, in place of that of each contact that has " // &
         "friction; not given, contensou_exact and its approximations, and those of the scene")
      call list%put("cost", "normal", kind_choice, choices=normal_names, values=most_values, &
         fewer=.true., &
         doc="normal force models that are compared, in place of that of each contact, each " // &
         "with each friction model; not given, that of each contact")
      call list%put("cost", "layers", kind_integer, values=most_values, fewer=.true., unit="1", &
         default="0, 6, 12, 24", least=0.0_wp, most=real(most_layers, wp), &
         doc="layers of the contacts with memory that are compared, 0 for tangential = " // &
         "'spring'; the reference has the most")
      call list%put("cost", "creep", kind_choice, choices=creep_names, values=most_values, &
         fewer=.true., doc="laws of creep that are compared, in place of that of each contact " // &
         "that has one, in place of numbers of layers; the reference has table, or " // &
         "boundary_elements if it is among them; not given, that of each contact")
      call list%put("cost", "methods", kind_choice, words=integrator_methods, values=most_values, &
         fewer=.true., &
         default="'cvode_bdf', 'cvode_adams', 'explicit8', 'auto'", &
         doc="methods of integration that are compared")
      call list%put("cost", "rtol", kind_real, values=most_values, fewer=.true., unit="1", &
         default="1.0e-4, 1.0e-6, 1.0e-8, 1.0e-10", least=1.0e-14_wp, most=1.0e-1_wp, &
         doc="relative tolerances that are compared, as integrator.rtol")
      call list%put("cost", "reference_rtol", kind_real, unit="1", default="1.0e-12", &
         least=1.0e-14_wp, most=1.0e-1_wp, &
         doc="relative tolerance of the reference solutions; smaller than all of rtol")
      call list%put("cost", "quantities", kind_choice, words=cost_quantities, values=most_values, &
         fewer=.true., &
         default="'position', 'angle', 'velocity'", &
         doc="what counts for the error of a run, the Pareto front and --error: the largest " // &
         "of the scaled errors of these; all are reported")
      call list%put("cost", "measure", kind_choice, words=cost_measures, default="'largest'", &
         doc="which error of position, angle, velocity and angular velocity counts: that at " // &
         "the end, the largest, or the root of the mean of the squares; all are reported")
      call list%put("cost", "samples", kind_integer, unit="1", default="1000", least=1.0_wp, &
         most=1.0e6_wp, doc="times after the beginning, equally far apart, at which " // &
         "trajectories are compared")
      call list%put("cost", "repeats", kind_integer, unit="1", default="3", least=1.0_wp, &
         most=1000.0_wp, &
         doc="times that a run of less than a second is done; the least CPU time counts")
      call list%put("cost", "cpu_limit", kind_real, unit="1", default="10.0", above=0.0_wp, &
         doc="CPU time at which a run is given up, in those of the reference of its model")
   end subroutine put_cost_keys

   !> Values of the group `cost`.
   subroutine build_cost(group, cost, diagnostics)
      type(group_settings_type), intent(in) :: group
      type(cost_spec_type), intent(inout) :: cost
      type(diagnostics_type), intent(inout) :: diagnostics
      integer :: i

      cost%friction = choices("friction")
      cost%normal = choices("normal")
      cost%creep = choices("creep")
      cost%layers = nint(group%vector("layers", group%count("layers")))
      cost%layers_given = group%is_given("layers")
      allocate(cost%methods(group%count("methods")))
      do i = 1, size(cost%methods)
         if (group%is_set("methods")) cost%methods(i) = group%text("methods", i)
      end do
      call refuse_doubles("methods", group%choices("methods"))
      call refuse_doubles("friction", cost%friction)
      call refuse_doubles("normal", cost%normal)
      call refuse_doubles("creep", cost%creep)
      ! 0 is a number of layers, and stands for a mistake there.
      if (group%is_set("layers")) call refuse_doubles("layers", cost%layers + 1)
      cost%rtol = group%vector("rtol", group%count("rtol"))
      cost%counts(choices("quantities")) = .true.
      cost%reference_rtol = group%number("reference_rtol")
      if (group%is_set("rtol") .and. cost%reference_rtol >= minval(cost%rtol)) call &
         diagnostics%add(group%place("reference_rtol", 1), &
         "the reference is not tighter than what it is compared with", &
         "reference_rtol < " // to_text(minval(cost%rtol)) // ", the smallest of rtol")
      cost%measure = max(1, group%choice("measure"))
      cost%samples = group%integer("samples")
      cost%repeats = group%integer("repeats")
      cost%cpu_limit = group%number("cpu_limit")

   contains

      !> Positions of the choices of a key; none if it has no usable value.
      function choices(name) result(list)
         character(len=*), intent(in) :: name
         integer, allocatable :: list(:)

         allocate(list(0))
         if (group%is_set(name)) list = group%choices(name)
      end function choices

      !> Nothing is compared with itself.
      subroutine refuse_doubles(name, list)
         character(len=*), intent(in) :: name
         !> Its choices; 0 after a mistake.
         integer, intent(in) :: list(:)
         integer :: j

         do j = 2, size(list)
            if (list(j) > 0 .and. any(list(:j - 1) == list(j))) call diagnostics%add( &
               group%place(name, j), word(name, j) // " stands twice in '" // name // &
               "'", "each choice once")
         end do
      end subroutine refuse_doubles

      !> A choice as it is written.
      function word(name, j)
         character(len=*), intent(in) :: name
         integer, intent(in) :: j
         character(len=:), allocatable :: word

         if (name == "layers") then
            word = to_text(cost%layers(j))
         else
            word = quote(group%text(name, j))
         end if
      end function word

   end subroutine build_cost

end module contensou_scene_cost
