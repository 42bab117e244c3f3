!> Differential geometry of a surface in its own frame: closest point, normal, second fundamental
!> form and its derivative.
!>
!> Conventions: the normal points out of the material; the form is that of the derivative of the
!> normal, dm = L xi, so that a convex surface has a positive one.
!> For an implicit surface F = 0 with G = |grad F|, normal m = grad F/G and form
!> h(u, v) = F''(u, v)/G the derivative of the form along the surface is
!> C(u, v, w) = (F'''(u, v, w) - h(u, v) F''(m, w) - h(v, w) F''(m, u) - h(w, u) F''(m, v))/G,
!> symmetric in its three arguments (Codazzi).
module contensou_contact_implicit_surface
   use contensou_base_kinds, only : wp
   use contensou_base_vectors, only : cross
   use contensou_contact_surface, only : shape_cylinder, shape_ellipsoid, shape_plane, &
      shape_sphere, shape_torus, surface_type
   implicit none(type, external)
   private

   public :: closest_point, normal_at, form_at, cubic_at, principal_at, return_to, any_tangent

   !> Most iterations for the point of an ellipsoid closest to a given one. Newton's method
   !> takes 3 to 6 of them, more only for points deep inside.
   integer, parameter :: most_iterations = 100

contains

   !> Point of a surface closest to a given point.
   !>
   !> Where several points are closest, as for the centre of a sphere, one of them is taken.
   pure subroutine closest_point(surface, p, x, normal, distance)
      type(surface_type), intent(in) :: surface
      !> Given point, frame of the surface [m].
      real(wp), intent(in) :: p(3)
      !> Closest point of the surface [m].
      real(wp), intent(out) :: x(3)
      !> Normal there, out of the material.
      real(wp), intent(out) :: normal(3)
      !> Distance, negative within the material [m].
      real(wp), intent(out) :: distance
      real(wp) :: rho, across, centre(3), length

      select case (surface%shape)
      case (shape_plane)
         normal = [0.0_wp, 0.0_wp, 1.0_wp]
         distance = p(3)
         x = [p(1), p(2), 0.0_wp]
      case (shape_sphere)
         length = sqrt(p(1)**2 + p(2)**2 + p(3)**2)
         normal = [0.0_wp, 0.0_wp, 1.0_wp]
         if (length > 0.0_wp) normal = p/length
         distance = length - surface%radius
         x = surface%radius*normal
      case (shape_cylinder)
         length = sqrt(p(1)**2 + p(2)**2)
         normal = [1.0_wp, 0.0_wp, 0.0_wp]
         if (length > 0.0_wp) normal(1:2) = p(1:2)/length
         distance = length - surface%radius
         x = surface%radius*normal
         x(3) = p(3)
      case (shape_torus)
         rho = sqrt(p(1)**2 + p(2)**2)
         centre = [1.0_wp, 0.0_wp, 0.0_wp]
         if (rho > 0.0_wp) centre(1:2) = p(1:2)/rho
         across = rho - surface%major_radius
         length = sqrt(across**2 + p(3)**2)
         normal = centre
         if (length > 0.0_wp) then
            normal(1:2) = across/length*centre(1:2)
            normal(3) = p(3)/length
         end if
         distance = length - surface%radius
         x = surface%major_radius*centre + surface%radius*normal
      case default
         call closest_of_ellipsoid(surface%semi_axes, p, x, normal, distance)
      end select
      if (surface%inside) then
         normal = -normal
         distance = -distance
      end if
   end subroutine closest_point

   !> Point of an ellipsoid closest to a given point: x_i = a_i^2 p_i/(t + a_i^2), where t is the
   !> largest root of s(t) = sum (a_i p_i/(t + a_i^2))^2 = 1. Newton's method on 1/sqrt(s), which is
   !> nearly linear and concave, climbs to it from any lower bound.
   pure subroutine closest_of_ellipsoid(semi_axes, p, x, normal, distance)
      !> Semi-axes [m].
      real(wp), intent(in) :: semi_axes(3)
      !> Given point [m].
      real(wp), intent(in) :: p(3)
      !> Closest point [m].
      real(wp), intent(out) :: x(3)
      !> Outward normal there.
      real(wp), intent(out) :: normal(3)
      !> Distance, negative inside [m].
      real(wp), intent(out) :: distance
      real(wp) :: square(3), q(3), y(3), t, s, slope, step, length, floor_t
      integer :: i, k

      square = semi_axes**2
      q = semi_axes*p
      length = sqrt(q(1)**2 + q(2)**2 + q(3)**2)
      ! At the root no term of s is above one, nor is s with the largest denominator in all terms.
      t = max(maxval(abs(q) - square), length - maxval(square))
      k = minloc(square, dim=1)
      floor_t = -square(k)*(1.0_wp - 4.0_wp*epsilon(t))
      t = max(t, floor_t)
      do i = 1, most_iterations
         y = q/(t + square)
         s = y(1)**2 + y(2)**2 + y(3)**2
         ! Where even the lower bound is too high, the point lies on a plane of symmetry between two
         ! closest points.
         if (s < 1.0_wp) exit
         slope = y(1)**2/(t + square(1)) + y(2)**2/(t + square(2)) + y(3)**2/(t + square(3))
         step = s*(sqrt(s) - 1.0_wp)/slope
         t = t + step
         if (abs(step) <= 1.0e-9_wp*abs(t + square(k))) exit
      end do
      x = square*p/(t + square)
      y = p/(t + square)
      if (t <= floor_t) then
         s = (x(1)/semi_axes(1))**2 + (x(2)/semi_axes(2))**2 + (x(3)/semi_axes(3))**2 &
            - (x(k)/semi_axes(k))**2
         x(k) = sign(semi_axes(k)*sqrt(max(1.0_wp - s, 0.0_wp)), p(k))
         y = x/square
      end if
      length = sqrt(y(1)**2 + y(2)**2 + y(3)**2)
      normal = y/length
      distance = t*length
   end subroutine closest_of_ellipsoid

   !> Normal at a point of a surface, out of the material.
   pure function normal_at(surface, x) result(normal)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)
      real(wp) :: rho

      select case (surface%shape)
      case (shape_plane)
         normal = [0.0_wp, 0.0_wp, 1.0_wp]
      case (shape_sphere)
         normal = x
      case (shape_cylinder)
         normal = [x(1), x(2), 0.0_wp]
      case (shape_torus)
         rho = sqrt(x(1)**2 + x(2)**2)
         normal(1:2) = (rho - surface%major_radius)/rho*x(1:2)
         normal(3) = x(3)
      case default
         normal = x/surface%semi_axes**2
      end select
      normal = normal/sqrt(normal(1)**2 + normal(2)**2 + normal(3)**2)
      if (surface%inside) normal = -normal
   end function normal_at

   !> A point near a surface brought back onto it.
   pure function return_to(surface, p) result(x)
      type(surface_type), intent(in) :: surface
      !> The point [m].
      real(wp), intent(in) :: p(3)
      real(wp) :: x(3)
      real(wp) :: normal(3), distance

      if (surface%shape == shape_ellipsoid) then
         x = p/sqrt(sum((p/surface%semi_axes)**2))
      else
         call closest_point(surface, p, x, normal, distance)
      end if
   end function return_to

   !> A unit vector perpendicular to a given one, without a root or a choice of axes (T. Duff et
   !> al., J. Computer Graphics Techniques 6 (2017) 1).
   pure function any_tangent(normal) result(tangent)
      !> Unit vector.
      real(wp), intent(in) :: normal(3)
      real(wp) :: tangent(3)
      real(wp) :: up, a

      up = sign(1.0_wp, normal(3))
      a = -1.0_wp/(up + normal(3))
      tangent(1) = 1.0_wp + up*normal(1)**2*a
      tangent(2) = up*normal(1)*normal(2)*a
      tangent(3) = -up*normal(1)
   end function any_tangent

   !> A principal direction at a point of a surface; any tangent where none is known beforehand.
   pure function principal_at(surface, x, normal) result(tangent)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      !> Normal there.
      real(wp), intent(in) :: normal(3)
      real(wp) :: tangent(3)
      real(wp) :: rho

      select case (surface%shape)
      case (shape_plane)
         tangent = [1.0_wp, 0.0_wp, 0.0_wp]
      case (shape_cylinder)
         tangent = [0.0_wp, 0.0_wp, 1.0_wp]
      case (shape_torus)
         rho = sqrt(x(1)**2 + x(2)**2)
         tangent = [-x(2)/rho, x(1)/rho, 0.0_wp]
      case default
         tangent = any_tangent(normal)
      end select
   end function principal_at

   !> Second fundamental form: components 11, 12, 22 in an orthonormal basis of tangents [1/m].
   pure function form_at(surface, x, normal, t) result(form)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      !> Normal there.
      real(wp), intent(in) :: normal(3)
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp) :: form(3)
      real(wp) :: around(2), rho, tube, ring, d(3), e(3)

      select case (surface%shape)
      case (shape_plane)
         form = 0.0_wp
         return
      case (shape_sphere)
         form = [1.0_wp, 0.0_wp, 1.0_wp]/surface%radius
      case (shape_cylinder)
         around = (normal(1)*t(2, :) - normal(2)*t(1, :))
         form = [around(1)**2, around(1)*around(2), around(2)**2]/surface%radius
      case (shape_torus)
         rho = sqrt(x(1)**2 + x(2)**2)
         around = (x(1)*t(2, :) - x(2)*t(1, :))/rho
         tube = 1.0_wp/surface%radius
         ring = (rho - surface%major_radius)*tube/rho
         form = tube*[1.0_wp, 0.0_wp, 1.0_wp] &
            + (ring - tube)*[around(1)**2, around(1)*around(2), around(2)**2]
      case default
         d = 1.0_wp/surface%semi_axes**2
         e = x*d
         form = [sum(t(:, 1)**2*d), sum(t(:, 1)*t(:, 2)*d), sum(t(:, 2)**2*d)] &
            /sqrt(e(1)**2 + e(2)**2 + e(3)**2)
      end select
      if (surface%inside) form = -form
   end function form_at

   !> Derivative of the second fundamental form along the surface: components 111, 112, 122, 222
   !> [1/m2].
   pure function cubic_at(surface, x, normal, t) result(cubic)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      !> Normal there.
      real(wp), intent(in) :: normal(3)
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp) :: cubic(4)
      real(wp) :: c(2), f(2), rho, e(3), e_ring(3), e_tube(3), outward(3), d(3), gradient, h(3), k

      outward = merge(-normal, normal, surface%inside)
      select case (surface%shape)
      case (shape_torus)
         ! The curvature around the axis, cos(phi)/rho, changes along the tube.
         rho = sqrt(x(1)**2 + x(2)**2)
         e_ring = [-x(2)/rho, x(1)/rho, 0.0_wp]
         e_tube = cross(e_ring, outward)
         e_tube = -e_tube
         c = matmul(e_ring, t)
         f = matmul(e_tube, t)
         k = -surface%major_radius/surface%radius*outward(3)/rho**2
         cubic(1) = 3.0_wp*k*c(1)**2*f(1)
         cubic(2) = k*(c(1)**2*f(2) + 2.0_wp*c(1)*c(2)*f(1))
         cubic(3) = k*(c(2)**2*f(1) + 2.0_wp*c(1)*c(2)*f(2))
         cubic(4) = 3.0_wp*k*c(2)**2*f(2)
      case (shape_ellipsoid)
         d = 1.0_wp/surface%semi_axes**2
         e = x*d
         gradient = sqrt(e(1)**2 + e(2)**2 + e(3)**2)
         h = [sum(t(:, 1)**2*d), sum(t(:, 1)*t(:, 2)*d), sum(t(:, 2)**2*d)]/gradient
         f = matmul(outward*d, t)
         cubic(1) = -3.0_wp*h(1)*f(1)/gradient
         cubic(2) = -(h(1)*f(2) + 2.0_wp*h(2)*f(1))/gradient
         cubic(3) = -(h(3)*f(1) + 2.0_wp*h(2)*f(2))/gradient
         cubic(4) = -3.0_wp*h(3)*f(2)/gradient
      case default
         cubic = 0.0_wp
      end select
      if (surface%inside) cubic = -cubic
   end function cubic_at

end module contensou_contact_implicit_surface
