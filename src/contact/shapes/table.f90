!> The shapes that a surface can have: the only list of them.
module contensou_contact_shapes_table
   use contensou_base_schema, only : key_list_type, key_type, kind_choice
   use contensou_base_text, only : string_type, strings
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_contact_shapes_cone, only : cone_type
   use contensou_contact_shapes_cylinder, only : cylinder_type
   use contensou_contact_shapes_ellipsoid, only : ellipsoid_type
   use contensou_contact_shapes_paraboloid, only : paraboloid_type
   use contensou_contact_shapes_plane, only : plane_type
   use contensou_contact_shapes_shape, only : shape_info_type, shape_type
   use contensou_contact_shapes_sphere, only : sphere_type
   use contensou_contact_shapes_torus, only : torus_type
   implicit none(type, external)
   private

   public :: shape_list_type, shape_item_type, shared_shapes, shape_names, put_shape_keys

   !> Sides of a surface that can be touched.
   character(len=*), parameter :: side_names(*) = [character(len=7) :: "outside", "inside"]

   !> A shape in a list.
   type :: shape_item_type
      class(shape_type), allocatable :: shape
      !> What does not depend on its size.
      type(shape_info_type) :: info
      type(key_list_type) :: keys
   end type shape_item_type

   !> Shapes of no particular size.
   type :: shape_list_type
      !> Number of shapes.
      integer :: n = 0
      !> The shapes, the first `n` of them.
      type(shape_item_type) :: items(32)
   contains
      procedure, private :: put
   end type shape_list_type

   !> A key in the making: its text in front of what it says of a shape, and behind.
   type :: joined_key_type
      type(key_type) :: key
      character(len=:), allocatable :: before
      character(len=:), allocatable :: after
      !> What it says of the shapes that have it.
      type(string_type), allocatable :: own(:)
      !> Number of shapes that have it.
      integer :: shapes = 0
   end type joined_key_type

   !> The shapes, made when they are first asked for: each case of a sweep reads by them.
   type(shape_list_type), allocatable, target :: table

contains

   !> All shapes, in one table for all. Thread-safe.
   function shared_shapes() result(list)
      type(shape_list_type), pointer :: list
      type(shape_list_type), allocatable :: made

      call lock_texts()
      if (.not. allocated(table)) then
         allocate(made)
         call all_shapes(made)
         call move_alloc(made, table)
      end if
      list => table
      call unlock_texts()
   end function shared_shapes

   !> All shapes, in the order of the documentation.
   subroutine all_shapes(list)
      type(shape_list_type), intent(out) :: list

      call list%put(sphere_type())
      call list%put(plane_type())
      call list%put(cylinder_type())
      call list%put(ellipsoid_type())
      call list%put(torus_type())
      call list%put(paraboloid_type())
      call list%put(cone_type())
   end subroutine all_shapes

   !> Add a shape.
   subroutine put(self, shape)
      class(shape_list_type), intent(inout) :: self
      class(shape_type), intent(in) :: shape

      self%n = self%n + 1
      associate (item => self%items(self%n))
         allocate(item%shape, source=shape)
         item%info = shape%info()
         call shape%put_keys(item%keys)
      end associate
   end subroutine put

   !> Names of the shapes.
   function shape_names() result(names)
      type(string_type), allocatable :: names(:)
      type(shape_list_type), pointer :: list
      integer :: i

      list => shared_shapes()
      allocate(names(list%n))
      do i = 1, list%n
         names(i)%s = trim(list%items(i)%info%name)
      end do
   end function shape_names

   !> Add the keys of all shapes to those of a scene; a key of several shapes is one key.
   subroutine put_shape_keys(keys)
      type(key_list_type), intent(inout) :: keys
      type(shape_list_type), pointer :: list
      type(joined_key_type) :: joined(64)
      character(len=:), allocatable :: hollows, without
      integer :: i, j, k, n

      list => shared_shapes()
      n = 0
      hollows = ""
      without = ""
      do i = 1, list%n
         associate (own => list%items(i)%keys, info => list%items(i)%info)
            do j = 1, own%n
               k = findloc(joined(:n)%key%name == own%keys(j)%name, .true., dim=1)
               if (k == 0) then
                  n = n + 1
                  k = n
                  joined(k)%key = own%keys(j)
               end if
               call join(joined(k), own%keys(j))
            end do
            if (info%hollow /= "") then
               hollows = hollows // ", a " // trim(info%hollow) // " (" // trim(info%name) // ")"
            else
               without = without // ", not for " // list%items(i)%shape%words()
            end if
         end associate
      end do
      do k = 1, n
         associate (key => joined(k)%key)
            key%doc = joined(k)%before // alternatives(joined(k)%own) // joined(k)%after
            if (joined(k)%shapes < list%n) key%doc = trim(key%doc) // &
               trim(merge("; mandatory there", "                 ", key%mandatory)) // &
               trim(merge(", not for other shapes", "; not for other shapes", key%mandatory))
            key%mandatory = key%mandatory .and. joined(k)%shapes == list%n
            call keys%append(key)
         end associate
      end do
      call keys%put("surface", "side", kind_choice, words=side_names, &
         doc="side of the shape that is touched, 'outside' if not given: with 'inside' the " // &
         "surface is concave" // hollows // ";" // without(2:))
   end subroutine put_shape_keys

   !> Join the texts of a key of two shapes.
   subroutine join(joined, key)
      type(joined_key_type), intent(inout) :: joined
      type(key_type), intent(in) :: key
      type(string_type), allocatable :: own(:)
      character(len=:), allocatable :: text
      integer :: first, last, i, n

      joined%shapes = joined%shapes + 1
      first = index(key%doc, "|")
      last = index(key%doc, "|", back=.true.)
      text = key%doc(first + 1:last - 1)
      if (.not. allocated(joined%own)) then
         joined%before = key%doc(:first - 1)
         joined%after = trim(key%doc(last + 1:))
         allocate(joined%own(0))
      end if
      n = size(joined%own)
      do i = 1, n
         if (joined%own(i)%s == text) return
      end do
      allocate(own(n + 1))
      do i = 1, n
         own(i)%s = joined%own(i)%s
      end do
      own(n + 1)%s = text
      call move_alloc(own, joined%own)
   end subroutine join

   !> "a, b or c".
   pure function alternatives(words) result(text)
      type(string_type), intent(in) :: words(:)
      character(len=:), allocatable :: text
      integer :: i

      text = words(1)%s
      do i = 2, size(words)
         if (i == size(words)) then
            text = text // " or " // words(i)%s
         else
            text = text // ", " // words(i)%s
         end if
      end do
   end function alternatives

end module contensou_contact_shapes_table
