!> The library: `use contensou` gives everything that a program needs to read a scene, simulate it
!> and look on, the kernels, and the tables of models. docs/library.md explains it.
!>
!> Other modules are not installed, and may change.
module contensou
   ! Kind of real numbers, version, errors.
   use contensou_base_build, only : program_version
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp

   ! Scenes and simulations.
   use contensou_scene_reader, only : scene_file_type
   use contensou_study_plain, only : new_simulation, read_scene, simulate
   use contensou_study_simulation, only : simulation_options_type, simulation_type

   ! Observers.
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   use contensou_integrate_observer, only : event_lift, event_touch, observer_type
   use contensou_integrate_motion, only : motion_type

   ! Kernels, with the types of their arguments; approximations of them stand in the tables.
   use contensou_contact_creep_law, only : creep_spot_type, creep_type, passing_type
   use contensou_contact_hertz, only : effective_modulus, hertz_contact, hertz_spot_type, &
      hertz_type
   use contensou_contact_kalker, only : kalker_coefficients
   use contensou_contact_spot, only : spot_shape_type
   use contensou_contact_tangential_shells, only : shells_type, spring_spot_type
   use contensou_contact_wrench, only : slip_type, wrench_exact_potential
   use contensou_contact_wrench_curved, only : bend_type, friction_wrench
   use contensou_special_elliptic, only : complete_elliptic

   ! Tables: models with their kernels, and the parts of a contact and the pairs of surfaces with
   ! all that a scene can name.
   use contensou_contact_creep, only : creep_models
   use contensou_contact_friction, only : friction_models
   use contensou_contact_hertz, only : hertz_models
   use contensou_contact_pairs, only : geometry_models
   use contensou_contact_parts, only : contact_parts
   use contensou_contact_vilke, only : vilke_models
   use contensou_special_elliptic, only : elliptic_models
   implicit none(type, external)
   public
end module contensou
