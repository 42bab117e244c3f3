!> Small scenes for the tests, made without a file.
module test_scenes
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_vectors, only : cross, frame_along
   use contensou_contact_damping, only : damping_model_type, damping_models
   use contensou_contact_friction, only : friction_model_type, friction_models
   use contensou_contact_rolling, only : rolling_model_type, rolling_models
   use contensou_contact_shapes_plane, only : plane_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_tangential, only : tangential_model_type, tangential_models
   use contensou_dynamics_scene, only : scene_type
   use contensou_integrate_motion, only : motion_type
   use contensou_study_simulation, only : new_simulation, simulation_type
   use test_harness, only : random_type
   implicit none(type, external)
   private

   public :: two_bodies, ball, set_motion, random_touch
   public :: damping_index, friction_index, rolling_index, tangential_index

contains

   !> Number of a damping law in its table.
   function damping_index(name) result(i)
      !> The law.
      character(len=*), intent(in) :: name
      integer :: i
      type(damping_model_type), allocatable :: models(:)

      models = damping_models()
      do i = 1, size(models)
         if (models(i)%info%name == name) return
      end do
      error stop "a damping law of this name is not in the table"
   end function damping_index

   !> Number of a friction model in its table.
   function friction_index(name) result(i)
      !> The model.
      character(len=*), intent(in) :: name
      integer :: i
      type(friction_model_type), allocatable :: models(:)

      models = friction_models()
      do i = 1, size(models)
         if (models(i)%info%name == name) return
      end do
      error stop "a friction model of this name is not in the table"
   end function friction_index

   !> Number of a law of rolling resistance in its table.
   function rolling_index(name) result(i)
      character(len=*), intent(in) :: name
      integer :: i
      type(rolling_model_type), allocatable :: models(:)

      models = rolling_models()
      do i = 1, size(models)
         if (models(i)%info%name == name) return
      end do
      error stop "a law of rolling resistance of this name is not in the table"
   end function rolling_index

   !> Number of a model of tangential elasticity in its table.
   function tangential_index(name) result(i)
      !> The model.
      character(len=*), intent(in) :: name
      integer :: i
      type(tangential_model_type), allocatable :: models(:)

      models = tangential_models()
      do i = 1, size(models)
         if (models(i)%info%name == name) return
      end do
      error stop "a model of tangential elasticity of this name is not in the table"
   end function tangential_index

   !> A body with a sphere and a body with a plane, both surfaces away from the centres of mass.
   subroutine two_bodies(scene, damping, friction, sphere_first)
      type(scene_type), intent(out) :: scene
      !> Number of the damping law.
      integer, intent(in) :: damping
      !> Number of the friction model.
      integer, intent(in) :: friction
      !> Whether the sphere is surface A.
      logical, intent(in) :: sphere_first

      scene%title = ""
      scene%t_end = 1.0_wp
      allocate(scene%materials(2), scene%bodies(2), scene%surfaces(2), scene%contacts(1))
      scene%materials(1)%young = 2.0e9_wp
      scene%materials(1)%poisson = 0.3_wp
      scene%materials(2)%young = 5.0e9_wp
      scene%materials(2)%poisson = 0.2_wp
      scene%bodies(1)%mass = 0.2_wp
      scene%bodies(1)%inertia = [3.0e-5_wp, 4.0e-5_wp, 5.0e-5_wp]
      scene%bodies(2)%mass = 0.5_wp
      scene%bodies(2)%inertia = [2.0e-4_wp, 1.5e-4_wp, 1.0e-4_wp]
      scene%surfaces(1)%body = 1
      scene%surfaces(1)%material = 1
      scene%surfaces(1)%surface%shape = sphere_type(1.5e-2_wp)
      scene%surfaces(1)%surface%centre = [1.0e-3_wp, -2.0e-3_wp, 3.0e-3_wp]
      scene%surfaces(2)%body = 2
      scene%surfaces(2)%material = 2
      scene%surfaces(2)%surface%shape = plane_type()
      scene%surfaces(2)%surface%centre = [-4.0e-3_wp, 2.0e-3_wp, 5.0e-3_wp]
      scene%surfaces(2)%surface%frame = frame_along([1.0_wp, 2.0_wp, -2.0_wp])
      associate (contact => scene%contacts(1))
         contact%surfaces = [2, 1]
         if (sphere_first) contact%surfaces = [1, 2]
         contact%damping = damping
         call contact%parameters%set("damping_coefficient", 0.4_wp)
         contact%friction = friction
         call contact%parameters%set("friction_coefficient", 0.3_wp)
         call contact%parameters%set("regularization_velocity", 1.0e-3_wp)
      end associate
      scene%integrator%method = "cvode_bdf"
      scene%integrator%rtol = 1.0e-9_wp
      scene%integrator%velocity_scale = 1.0e-2_wp
      scene%integrator%angular_velocity_scale = 1.0_wp
   end subroutine two_bodies

   !> A steel ball above the ground, and a ceiling if wanted; elastic, without friction and gravity.
   subroutine ball(scene, height, ceiling_height)
      type(scene_type), intent(out) :: scene
      !> Gap below the ball [m].
      real(wp), intent(in) :: height
      !> Height of the ceiling above the ground [m]; none if not given.
      real(wp), intent(in), optional :: ceiling_height
      integer :: i, n

      n = 1
      if (present(ceiling_height)) n = 2
      scene%title = ""
      scene%t_end = 1.0_wp
      allocate(scene%materials(1), scene%bodies(1), scene%surfaces(1 + n), scene%contacts(n))
      scene%materials(1)%young = 2.1e11_wp
      scene%materials(1)%poisson = 0.3_wp
      scene%bodies(1)%mass = 0.1_wp
      scene%bodies(1)%inertia = 1.6e-5_wp
      scene%bodies(1)%position = [0.0_wp, 0.0_wp, 0.02_wp + height]
      scene%surfaces%material = 1
      scene%surfaces(1)%body = 1
      scene%surfaces(1)%surface%shape = sphere_type(0.02_wp)
      do i = 2, 1 + n
         scene%surfaces(i)%body = 0
         scene%surfaces(i)%surface%shape = plane_type()
         scene%contacts(i - 1)%surfaces = [i, 1]
      end do
      if (n == 2) then
         scene%surfaces(3)%surface%centre = [0.0_wp, 0.0_wp, ceiling_height]
         scene%surfaces(3)%surface%frame = frame_along([0.0_wp, 0.0_wp, -1.0_wp])
      end if
      scene%integrator%method = "cvode_bdf"
      scene%integrator%rtol = 1.0e-9_wp
      scene%integrator%velocity_scale = 1.0e-2_wp
      scene%integrator%angular_velocity_scale = 1.0_wp
   end subroutine ball

   !> Equations of motion and initial state of a scene.
   subroutine set_motion(scene, motion, y)
      !> The scene; its length scale is filled in.
      type(scene_type), intent(inout) :: scene
      type(motion_type), intent(out) :: motion
      !> The initial state.
      real(wp), allocatable, intent(out) :: y(:)

      type(simulation_type) :: simulation
      type(error_type), allocatable :: error

      call new_simulation(scene, simulation, error)
      if (allocated(error)) error stop "a scene of the tests cannot be simulated"
      scene%integrator%length_scale = simulation%scene%integrator%length_scale
      motion = simulation%motion
      call motion%lay_out_jacobian()
      y = simulation%state()
   end subroutine set_motion

   !> A random state of `two_bodies` with a given gap.
   subroutine random_touch(scene, random, gap, y)
      type(scene_type), intent(in) :: scene
      !> The generator.
      type(random_type), intent(inout) :: random
      !> The gap [m].
      real(wp), intent(in) :: gap
      !> State; what follows the two bodies is not set.
      real(wp), intent(inout) :: y(:)
      real(wp) :: sphere(3, 3), plane(3, 3), normal(3), along(3)

      y(:26) = 0.0_wp
      y(4:7) = random%vector(4)
      y(17:20) = random%vector(4)
      y(4:7) = y(4:7)/norm2(y(4:7))
      y(17:20) = y(17:20)/norm2(y(17:20))
      y(8:10) = 0.3_wp*random%vector(3)
      y(21:23) = 0.3_wp*random%vector(3)
      y(11:13) = 40.0_wp*random%vector(3)
      y(24:26) = 40.0_wp*random%vector(3)
      sphere = rotation_matrix(y(4:7))
      plane = rotation_matrix(y(17:20))
      y(14:16) = random%vector(3)
      associate (s => scene%surfaces(1)%surface, p => scene%surfaces(2)%surface)
         normal = matmul(plane, p%frame(:, 3))
         along = 0.01_wp*cross(normal, random%vector(3))
         y(1:3) = y(14:16) + matmul(plane, p%centre) + along + (s%shape%extent() + gap)*normal &
            - matmul(sphere, s%centre)
      end associate
   end subroutine random_touch

end module test_scenes
