!> Words for places in a data set, by the scales of its dimensions: time, body, component, contact,
!> case.
module contensou_compare_places
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : power_text, read_real, to_text
   use contensou_base_text, only : shorten, string_type
   use contensou_compare_values, only : integer_text
   use contensou_files_hdf5_reader, only : class_integer, class_real, class_text, class_unsigned, &
      hdf5_item_type, max_rank
   implicit none(type, external)
   private

   public :: place_text, time_text, printable

contains

   !> Words for a place in a data set, by the scales of its dimensions.
   function place_text(item, path, place) result(text)
      !> The data set or attribute.
      type(hdf5_item_type), intent(in) :: item
      character(len=*), intent(in) :: path
      !> Indices.
      integer(i8), intent(in) :: place(max_rank)
      !> Such as "t = 1.2 s, body top, component z"; empty for a single value.
      character(len=:), allocatable :: text
      type(hdf5_item_type) :: scale
      character(len=:), allocatable :: part
      integer :: d

      text = ""
      do d = 1, item%rank
         call item%open_scale(d - 1, scale)
         part = ""
         if (scale%is_open()) call scale_text(scale, path, place(d), part)
         call scale%close()
         if (part == "") then
            part = printable(item%dimension_name(d - 1))
            if (part == "") part = "index"
            part = part // " " // to_text(place(d))
         end if
         if (d > 1) text = text // ", "
         text = text // part
      end do
   end function place_text

   !> Words for a place on a scale.
   subroutine scale_text(scale, path, i, text)
      type(hdf5_item_type), intent(in) :: scale
      !> Path of the data set that it belongs to.
      character(len=*), intent(in) :: path
      integer(i8), intent(in) :: i
      !> Such as "body top"; empty if the scale has no such place.
      character(len=:), allocatable, intent(out) :: text
      type(error_type), allocatable :: error
      type(string_type), allocatable :: texts(:)
      character(len=:), allocatable :: name, units
      integer(i8) :: k(1)
      real(wp) :: x(1)
      integer :: slash

      text = ""
      if (i >= scale%extents(1)) return
      name = printable(scale%name)
      slash = index(path, "/", back=.true.)
      ! A scale that is looked at itself has nothing else to go by than its index.
      if (path(slash + 1:) == scale%name) return
      select case (name)
      case ("")
         name = "index"
      case ("xyz", "wxyz")
         name = "component"
      case ("name")
         ! The bodies of /body, the contacts of /contact.
         slash = slash - 1
         if (slash > 0) name = printable(path(index(path(:slash), "/", back=.true.) + 1:slash))
      case default
         ! The others speak for themselves.
         continue
      end select
      select case (scale%class)
      case (class_text)
         call scale%read_texts([i], [1_i8], 1, texts, error)
         if (.not. allocated(error)) text = name // " " // shorten(printable(texts(1)%s), 40)
      case (class_real)
         call scale%read([i], [1_i8], x, error)
         if (allocated(error)) return
         units = scale%units()
         if (units == "1") units = ""
         if (name == "time") name = "t"
         text = name // " = " // time_text(x(1))
         if (units /= "") text = text // " " // printable(units)
      case (class_integer, class_unsigned)
         call scale%read([i], [1_i8], k, error)
         if (.not. allocated(error)) text = name // " " // integer_text(k(1), &
            scale%class == class_unsigned)
      case default
         ! Other values are no labels.
         continue
      end select
   end subroutine scale_text

   !> A time or another number of a scale in at most ten digits.
   pure function time_text(x) result(text)
      real(wp), intent(in) :: x
      character(len=:), allocatable :: text
      real(wp) :: rounded
      logical :: valid

      text = to_text(x)
      if (len(text) <= 12) return
      call read_real(power_text(x, 10), rounded, valid)
      text = to_text(rounded)
   end function time_text

   !> A text without control characters.
   pure function printable(text) result(clean)
      character(len=*), intent(in) :: text
      !> The same with '?' in their place; line ends of messages stay.
      character(len=len(text)) :: clean
      integer :: i

      clean = text
      do i = 1, len(text)
         if (ichar(text(i:i)) < 32 .or. ichar(text(i:i)) == 127) clean(i:i) = "?"
      end do
   end function printable

end module contensou_compare_places
