!> Contact law: the four exchangeable parts of a contact, and the load they give together.
!>
!> A part that a scene does not name is absent, not zero: it is neither evaluated nor stored.
module contensou_contact_law
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_damping, only : damping_type
   use contensou_contact_friction, only : friction_type
   use contensou_contact_geometry, only : contact_point_type, geometry_type
   use contensou_contact_normal, only : normal_type
   implicit none(type, external)
   private

   public :: contact_law_type, contact_load_type

   !> The four parts.
   type :: contact_law_type
      !> Where the surfaces are closest.
      class(geometry_type), allocatable :: geometry
      !> Normal force.
      type(normal_type) :: normal
      !> Damping; unallocated for none.
      type(damping_type), allocatable :: damping
      !> Friction; unallocated for none.
      type(friction_type), allocatable :: friction
      !> Largest approach that Hertz's theory admits [m].
      real(wp) :: largest_approach = 0.0_wp
   contains
      !> Load of closed contact.
      procedure :: evaluate
   end type contact_law_type

   !> What a closed contact does to body B (and, reversed, to body A).
   type :: contact_load_type
      !> Normal force N [N], >= 0.
      real(wp) :: normal_force = 0.0_wp
      !> Friction force on B [N], inertial frame.
      real(wp) :: friction_force(3) = 0.0_wp
      !> Friction torque on B about the normal [N m].
      real(wp) :: friction_torque = 0.0_wp
      !> Slip velocity of B against A in the tangent plane [m/s], inertial frame.
      real(wp) :: slip(3) = 0.0_wp
      !> Spin of B against A about the normal [rad/s].
      real(wp) :: spin = 0.0_wp
      !> Power lost in friction [W], >= 0.
      real(wp) :: friction_power = 0.0_wp
      !> Power lost in damping [W], >= 0.
      real(wp) :: damping_power = 0.0_wp
   end type contact_load_type

contains

   !> Load of a closed contact.
   pure subroutine evaluate(self, at, velocity, spin, load)
      !> The law.
      class(contact_law_type), intent(in) :: self
      !> Geometry of the contact, its gap < 0.
      type(contact_point_type), intent(in) :: at
      !> Velocity of B against A at the contact point [m/s].
      real(wp), intent(in) :: velocity(3)
      !> Angular velocity of B against A [rad/s].
      real(wp), intent(in) :: spin(3)
      !> The load.
      type(contact_load_type), intent(out) :: load
      real(wp) :: approach, rate, elastic, minor(3), fx, fy, vx, vy

      approach = -at%gap
      elastic = self%normal%force(approach)
      load%normal_force = elastic
      if (allocated(self%damping)) then
         rate = -dot_product(velocity, at%normal)
         load%normal_force = self%damping%total(elastic, approach, rate)
         load%damping_power = (load%normal_force - elastic)*rate
      end if
      if (allocated(self%friction)) then
         minor = cross(at%normal, at%major)
         vx = dot_product(velocity, at%major)
         vy = dot_product(velocity, minor)
         load%slip = vx*at%major + vy*minor
         load%spin = dot_product(spin, at%normal)
         call self%friction%wrench(load%normal_force, self%normal%shape, &
            self%normal%major_axis(approach), vx, vy, load%spin, fx, fy, load%friction_torque)
         load%friction_force = fx*at%major + fy*minor
         load%friction_power = -(fx*vx + fy*vy + load%friction_torque*load%spin)
      end if
   end subroutine evaluate

end module contensou_contact_law
