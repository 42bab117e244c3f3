!> Surfaces of bodies: shapes, and where they sit on their body.
!>
!> A surface is the boundary of a solid of its shape. With `inside` the material is outside of that
!> solid: a socket, a bore, a groove, touched from within. The normal points out of the material.
module contensou_contact_surface
   use contensou_base_diagnostics, only : diagnostics_type
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : domain_text, key_list_type, key_type, kind_real
   use contensou_base_settings, only : group_settings_type
   use contensou_base_text, only : quote, string_type
   use contensou_contact_shapes_shape, only : shape_info_type, shape_type
   use contensou_contact_shapes_table, only : shape_item_type, shape_list_type, &
      shared_shapes
   implicit none(type, external)
   private

   public :: surface_type, size_type, read_surface
   public :: closest_point, normal_at, form_at, cubic_at

   !> Keys of a surface that are not those of its shape.
   character(len=*), parameter :: common_keys(*) = [character(len=8) :: "name", "body", "shape", &
      "material"]

   !> A surface in the frame of its body.
   type :: surface_type
      class(shape_type), allocatable :: shape
      !> Whether it is touched from the inside of its shape.
      logical :: inside = .false.
      !> Origin of the frame of its shape [m].
      real(wp) :: centre(3) = 0.0_wp
      !> Rotation matrix, frame of the shape to frame of the body; its third column is the outward
      !> normal of a plane and the axis of what has an axis of revolution.
      real(wp) :: frame(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
   contains
      procedure :: words
      procedure :: label
      procedure :: is_outside_of
   end type surface_type

   !> A size of a shape, as the scene gives it.
   type :: size_type
      !> Key of the scene.
      character(len=28) :: name = ""
      !> UDUNITS text.
      character(len=12) :: unit = ""
      !> Its values, the first `n`.
      real(wp) :: values(3) = 0.0_wp
      integer :: n = 0
   end type size_type

contains

   !> Read a surface from the settings of its group.
   subroutine read_surface(group, surface, sizes, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> The surface; without a shape if that is unknown.
      type(surface_type), intent(inout) :: surface
      !> Sizes of its shape, and behind them some without name.
      type(size_type), intent(out) :: sizes(:)
      type(diagnostics_type), intent(inout) :: diagnostics
      type(shape_list_type), pointer :: list
      integer :: chosen

      chosen = group%choice("shape")
      if (chosen < 1) return
      list => shared_shapes()
      allocate(surface%shape, source=list%items(chosen)%shape)
      surface%centre = group%numbers("centre")
      surface%inside = group%choice("side") == 2
      call surface%shape%read(group, surface%frame, diagnostics)
      call check_keys(group, list%items(chosen), diagnostics)
      call list_sizes(group, list%items(chosen)%keys, sizes)
   end subroutine read_surface

   !> Sizes of a shape: its keys of numbers above zero.
   subroutine list_sizes(group, own, sizes)
      type(group_settings_type), intent(in) :: group
      !> Keys of the shape.
      type(key_list_type), intent(in) :: own
      type(size_type), intent(inout) :: sizes(:)
      integer :: i, n

      n = 0
      do i = 1, own%n
         associate (key => own%keys(i))
            if (.not. is_size(key) .or. n == size(sizes)) cycle
            n = n + 1
            sizes(n)%name = key%name
            sizes(n)%unit = key%unit
            sizes(n)%n = key%values
            sizes(n)%values(:key%values) = group%numbers(key%name)
         end associate
      end do

   contains

      !> Whether a key gives a size.
      pure logical function is_size(key)
         type(key_type), intent(in) :: key

         is_size = key%kind == kind_real .and. key%mandatory .and. key%above_low .and. &
            key%values >= 1 .and. key%values <= 3
      end function is_size

   end subroutine list_sizes

   !> Keys that the shape of a surface does not have, and those that it needs.
   subroutine check_keys(group, item, diagnostics)
      type(group_settings_type), intent(in) :: group
      !> The shape with its keys.
      type(shape_item_type), intent(in) :: item
      type(diagnostics_type), intent(inout) :: diagnostics
      type(string_type), allocatable :: given(:)
      character(len=:), allocatable :: name
      integer :: i

      given = group%given_keys()
      do i = 1, size(given)
         associate (key => given(i)%s)
            if (any(common_keys == key) .or. item%keys%has(key)) cycle
            if (key == "side" .and. item%info%hollow /= "") cycle
            call group%refuse(key, item%shape%words() // " has no " // quote(key), &
               trim(item%info%hint), diagnostics)
         end associate
      end do
      do i = 1, item%keys%n
         associate (key => item%keys%keys(i))
            if (.not. key%mandatory) cycle
            if (.not. group%lacks(key%name)) cycle
            name = trim(key%name)
            call diagnostics%add(group%origin, quote(name) // " is missing for the " // &
               trim(item%info%name) // " " // quote(group%label()), name // " = " // &
               domain_text(key))
         end associate
      end do
   end subroutine check_keys

   !> A surface in words, as "a sphere" or "the inside of a torus".
   pure function words(self) result(text)
      class(surface_type), intent(in) :: self
      character(len=:), allocatable :: text

      text = self%shape%words()
      if (self%inside) text = "the inside of " // text
   end function words

   !> Shape of a surface, and its side if that is the inside.
   pure function label(self) result(text)
      class(surface_type), intent(in) :: self
      character(len=:), allocatable :: text
      type(shape_info_type) :: info

      info = self%shape%info()
      text = trim(info%name)
      if (self%inside) text = text // " (inside)"
   end function label

   !> Whether it is the outside of a given shape.
   pure logical function is_outside_of(self, name)
      class(surface_type), intent(in) :: self
      !> Name of the shape.
      character(len=*), intent(in) :: name
      type(shape_info_type) :: info

      info = self%shape%info()
      is_outside_of = info%name == name .and. .not. self%inside
   end function is_outside_of

   !> Point of a surface closest to a given point, in its frame.
   pure subroutine closest_point(surface, p, x, normal, distance)
      type(surface_type), intent(in) :: surface
      !> Given point [m].
      real(wp), intent(in) :: p(3)
      !> Closest point of the surface [m].
      real(wp), intent(out) :: x(3)
      real(wp), intent(out) :: normal(3)
      !> Distance, negative within the material [m].
      real(wp), intent(out) :: distance

      call surface%shape%closest(p, x, normal, distance)
      if (surface%inside) then
         normal = -normal
         distance = -distance
      end if
   end subroutine closest_point

   !> Normal at a point of a surface.
   pure function normal_at(surface, x) result(normal)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      real(wp) :: normal(3)

      normal = surface%shape%normal(x)
      if (surface%inside) normal = -normal
   end function normal_at

   !> Second fundamental form: components 11, 12, 22 in an orthonormal basis of tangents [1/m].
   pure subroutine form_at(surface, x, normal, t, form)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      real(wp), intent(in) :: normal(3)
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp), intent(out) :: form(3)

      call surface%shape%form(x, normal, t, form)
      if (surface%inside) form = -form
   end subroutine form_at

   !> Its derivative along the surface: components 111, 112, 122, 222 [1/m2].
   pure subroutine cubic_at(surface, x, normal, t, cubic)
      type(surface_type), intent(in) :: surface
      !> Point of the surface [m].
      real(wp), intent(in) :: x(3)
      real(wp), intent(in) :: normal(3)
      !> The two tangents.
      real(wp), intent(in) :: t(3, 2)
      real(wp), intent(out) :: cubic(4)

      if (surface%inside) then
         call surface%shape%cubic(x, -normal, t, cubic)
         cubic = -cubic
      else
         call surface%shape%cubic(x, normal, t, cubic)
      end if
   end subroutine cubic_at

end module contensou_contact_surface
