!> Full sliding as a law of creep: the wrench as if nothing stuck, whatever rolls through the spot.
!> The other laws come to it where rolling stops and where creep is large.
module contensou_contact_creep_sliding
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep_law, only : creep_model_type, creep_motion_type, creep_spot_type, &
      creep_type, n_velocities
   use contensou_contact_parameters, only : parameters_type
   use contensou_contact_wrench, only : slip_type, wrench_exact, wrench_exact_jacobian
   implicit none(type, external)
   private

   public :: full_sliding

   type, extends(creep_type) :: full_sliding_type
   contains
      procedure :: kernel
      procedure :: kernel_slopes
   end type full_sliding_type

contains

   !> Row of full sliding.
   function full_sliding() result(model)
      type(creep_model_type) :: model

      model%info = model_info_type("sliding", "nothing sticks, at any creep: the exact " // &
         "Contensou-Erismann wrench", "", &
         "P. Contensou, in: Kreiselprobleme, 1963; Th. Erismann, ZAMP 5 (1954) 355")
      model%create => new_full_sliding
   end function full_sliding

   !> Make the law.
   subroutine new_full_sliding(parameters, creep)
      type(parameters_type), intent(in) :: parameters
      class(creep_type), allocatable, intent(out) :: creep

      allocate(full_sliding_type :: creep)
      creep%sticks = .false.
   end subroutine new_full_sliding

   !> The exact wrench.
   pure subroutine kernel(self, spot, motion, wrench)
      class(full_sliding_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)

      call wrench_exact(spot%shape, slip_type(motion%x, motion%y, motion%spin), .true., wrench)
   end subroutine kernel

   !> The exact wrench and its derivatives.
   pure subroutine kernel_slopes(self, spot, motion, wrench, jacobian)
      class(full_sliding_type), intent(in) :: self
      type(creep_spot_type), intent(in) :: spot
      type(creep_motion_type), intent(in) :: motion
      !> Force along the major and the minor axis, torque about the normal.
      real(wp), intent(out) :: wrench(3)
      !> Derivative of component i by x, y, spin, rx, ry.
      real(wp), intent(out) :: jacobian(3, n_velocities)

      jacobian = 0.0_wp
      call wrench_exact_jacobian(spot%shape, slip_type(motion%x, motion%y, motion%spin), wrench, &
         jacobian(:, :3))
   end subroutine kernel_slopes

end module contensou_contact_creep_sliding
