!> Description of a scene as read, checked and resolved: plain data, no behaviour.
module contensou_dynamics_scene
   use contensou_base_kinds, only : wp
   use contensou_contact_normal, only : normal_hertz
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_surface, only : size_type, surface_type
   use contensou_dynamics_springs, only : spring_type
   implicit none(type, external)
   private

   public :: scene_type, material_spec_type, body_spec_type, surface_spec_type
   public :: contact_spec_type, integrator_spec_type, output_spec_type, stop_spec_type, &
      spring_spec_type
   public :: stop_rest, stop_touch, stop_lift, stop_angle, stop_speed, stop_spin, stop_position, &
      stop_conforming, stop_names, crossing_any, crossing_rising, crossing_falling, crossing_names
   public :: motion_free, motion_fixed, motion_prescribed, motion_spindle, motion_names
   public :: motion_rotor
   public :: moves_freely, turns_by_drive, frame_names, impact_names, impacts_together, &
      solid_parts

   !> How a body moves: by Newton-Euler, not at all, as prescribed, turning as prescribed while its
   !> centre of mass moves freely, or turning as prescribed about its third axis while it moves and
   !> tilts freely.
   integer, parameter :: motion_free = 1, motion_fixed = 2, motion_prescribed = 3, &
      motion_spindle = 4, motion_rotor = 5

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: motion_names(*) = [character(len=10) :: &
      "free", "fixed", "prescribed", "spindle", "rotor"]

   !> Whether forces accelerate the centre of mass, for each of the codes.
   logical, parameter :: moves_freely(*) = [.true., .false., .false., .true., .true.]

   !> Whether a drive prescribes the rotation, or that about the third axis, for each of the codes.
   logical, parameter :: turns_by_drive(*) = [.false., .false., .true., .true., .true.]

   !> Frames in which an applied load can be constant.
   character(len=*), parameter :: frame_names(*) = [character(len=8) :: "inertial", "body"]

   !> Parts of a sphere or ellipsoid that a solid can be.
   character(len=*), parameter :: solid_parts(*) = [character(len=10) :: "whole", "lower_half", &
      "upper_half"]

   !> How impacts of several rigid contacts at one instant are taken.
   character(len=*), parameter :: impact_names(*) = [character(len=12) :: &
      "sequential", "simultaneous"]

   !> The one of them that takes them all at once.
   character(len=*), parameter :: impacts_together = "simultaneous"

   !> What a condition that ends a run is about.
   integer, parameter :: stop_rest = 1, stop_touch = 2, stop_lift = 3, stop_angle = 4, &
      stop_speed = 5, stop_spin = 6, stop_position = 7, stop_conforming = 8

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: stop_names(*) = [character(len=10) :: "rest", "touch", "lift", &
      "angle", "speed", "spin", "position", "conforming"]

   !> How a quantity crosses its threshold.
   integer, parameter :: crossing_any = 1, crossing_rising = 2, crossing_falling = 3

   !> Their names in a scene, in the order of the codes.
   character(len=*), parameter :: crossing_names(*) = [character(len=7) :: "any", "rising", &
      "falling"]

   !> Elastic material.
   type :: material_spec_type
      character(len=:), allocatable :: name
      !> Young's modulus [Pa].
      real(wp) :: young = 0.0_wp
      !> Poisson's ratio [-].
      real(wp) :: poisson = 0.0_wp
   end type material_spec_type

   !> Rigid body and its initial state.
   type :: body_spec_type
      character(len=:), allocatable :: name
      !> How it moves, one of the `motion_*` codes.
      integer :: motion = motion_free
      !> Mass [kg].
      real(wp) :: mass = 0.0_wp
      !> Principal moments of inertia about the centre of mass, body axes [kg m2].
      real(wp) :: inertia(3) = 0.0_wp
      !> Centre of mass [m], inertial frame.
      real(wp) :: position(3) = 0.0_wp
      !> Unit quaternion (w, x, y, z), body to inertial frame.
      real(wp) :: quaternion(4) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      !> Velocity of the centre of mass [m/s], inertial frame.
      real(wp) :: velocity(3) = 0.0_wp
      !> Angular velocity [rad/s], body frame.
      real(wp) :: spin(3) = 0.0_wp
      !> Velocity of a prescribed motion after its ramp [m/s], inertial frame.
      real(wp) :: final_velocity(3) = 0.0_wp
      !> Angular velocity of a prescribed motion after its ramp [rad/s], inertial frame.
      real(wp) :: final_angular_velocity(3) = 0.0_wp
      !> Duration of the ramp [s]; 0 for none.
      real(wp) :: ramp_duration = 0.0_wp
      !> Direction in which statics hold the body, inertial frame; zero for none.
      real(wp) :: held_along(3) = 0.0_wp
      !> Force applied at the centre of mass [N].
      real(wp) :: applied_force(3) = 0.0_wp
      !> Torque applied [N m].
      real(wp) :: applied_torque(3) = 0.0_wp
      !> Whether force and torque turn with the body.
      logical :: load_follows = .false.
   end type body_spec_type

   !> Surface on a body.
   type :: surface_spec_type
      character(len=:), allocatable :: name
      !> Index of the body; 0 for the ground.
      integer :: body = 0
      integer :: material = 0
      !> The surface in the frame of its body.
      type(surface_type) :: surface
      !> What its shape measures, and behind it some without name.
      type(size_type) :: sizes(4)
      !> The solid of the body that it bounds: which of `solid_parts` of the shape, 0 where the
      !> scene speaks of none, and its length where the shape has no ends [m].
      integer :: solid_part = 0
      real(wp) :: solid_length = 0.0_wp
   end type surface_spec_type

   !> Contact of two surfaces.
   type :: contact_spec_type
      character(len=:), allocatable :: name
      !> Indices of the surfaces A and B.
      integer :: surfaces(2) = 0
      !> Which of the spots of its surfaces it is, and how many they have; all of them follow one
      !> another, and differ in name only.
      integer :: spot = 1, spots = 1
      !> Index into `normal_models`.
      integer :: normal = normal_hertz
      !> Index into `damping_models`.
      integer :: damping = 1
      !> Index into `friction_models`.
      integer :: friction = 1
      !> Index into `rolling_models`.
      integer :: rolling = 1
      !> Index into `tangential_models`.
      integer :: tangential = 1
      !> Index into `curvature_models`.
      integer :: curvature = 1
      !> Values of the keys of the models.
      type(parameters_type) :: parameters
   end type contact_spec_type

   !> How to integrate.
   type :: integrator_spec_type
      !> Method, as in the scene.
      character(len=:), allocatable :: method
      !> Whether the Jacobian of an implicit method comes from differences.
      logical :: differences = .false.
      !> Steps after which that method renews its Jacobian, >= 1.
      integer :: jacobian_steps = 10
      !> Relative tolerance [-].
      real(wp) :: rtol = 0.0_wp
      !> Length that the tolerance of a position refers to [m]; 0 to derive it from the scene.
      real(wp) :: length_scale = 0.0_wp
      !> Velocity below which tolerances are absolute [m/s].
      real(wp) :: velocity_scale = 0.0_wp
      !> Angular velocity below which tolerances are absolute [rad/s].
      real(wp) :: angular_velocity_scale = 0.0_wp
      !> Largest step [s]; 0 for no bound.
      real(wp) :: max_step = 0.0_wp
   end type integrator_spec_type

   !> Condition that ends a run.
   type :: stop_spec_type
      character(len=:), allocatable :: name
      !> One of the `stop_*` codes.
      integer :: kind = 0
      !> Index of the body; 0 for all.
      integer :: body = 0
      !> Index of the contact; 0 for any.
      integer :: contact = 0
      !> Value at which the run ends: energy [J], angle [rad], speed [m/s], angular velocity [rad/s]
      !> or position [m].
      real(wp) :: threshold = 0.0_wp
      !> Time for which bodies are to be at rest [s].
      real(wp) :: duration = 0.0_wp
      !> Unit vector in the frame of the body.
      real(wp) :: axis(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> Unit vector in the inertial frame.
      real(wp) :: direction(3) = [0.0_wp, 0.0_wp, 1.0_wp]
      !> One of the `crossing_*` codes.
      integer :: crossing = crossing_any
   end type stop_spec_type

   !> What to write.
   type :: output_spec_type
      !> Name of the output file.
      character(len=:), allocatable :: file
      !> Time between rows [s].
      real(wp) :: interval = 0.0_wp
      !> Whether rows hold contact points, normals and directions of spots.
      logical :: contact_geometry = .true.
      !> Whether rows hold rolling velocities and creepages.
      logical :: rolling = .false.
   end type output_spec_type

   !> Spring between two bodies.
   type, extends(spring_type) :: spring_spec_type
      character(len=:), allocatable :: name
      !> Whether the points of A and of B are given.
      logical :: placed(2) = .false.
      !> Whether the relaxed length, and the relaxed attitude of B against A, are given.
      logical :: measured = .false., aligned = .false.
   end type spring_spec_type

   !> All that a scene file says, read and checked, before anything is assembled.
   type :: scene_type
      character(len=:), allocatable :: title
      !> Acceleration of gravity [m/s2], inertial frame.
      real(wp) :: gravity(3) = 0.0_wp
      !> End of the simulated time [s].
      real(wp) :: t_end = 0.0_wp
      !> Whether rigid contacts that touch at one instant impact at once.
      logical :: together = .false.
      type(material_spec_type), allocatable :: materials(:)
      !> Bodies, without the ground.
      type(body_spec_type), allocatable :: bodies(:)
      type(surface_spec_type), allocatable :: surfaces(:)
      type(contact_spec_type), allocatable :: contacts(:)
      !> Springs; not allocated for none.
      type(spring_spec_type), allocatable :: springs(:)
      !> Conditions that end a run before `t_end`; not allocated for none.
      type(stop_spec_type), allocatable :: stops(:)
      type(integrator_spec_type) :: integrator
      type(output_spec_type) :: output
   end type scene_type

end module contensou_dynamics_scene
