!> Pairs of surfaces that can touch: the ways to their closest points in one table, and why others
!> cannot touch in a point.
module contensou_contact_pairs
   use contensou_base_kinds, only : wp
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_geometry, only : geometry_type
   use contensou_contact_search, only : carrier_rank
   use contensou_contact_shapes_shape, only : shape_info_type, shape_type
   use contensou_contact_shapes_table, only : shape_list_type, shared_shapes
   use contensou_contact_sphere_plane, only : new_sphere_plane
   use contensou_contact_surface, only : surface_type
   use contensou_contact_surface_pair, only : new_axes_pair, new_ball_pair, new_searched_pair, &
      new_support_pair
   implicit none(type, external)
   private

   public :: geometry_models, new_geometry

   abstract interface
      !> The geometry of two surfaces.
      subroutine pair_interface(a, b, first_is_a, geometry)
         import :: geometry_type, surface_type
         implicit none(type, external)
         type(surface_type), intent(in) :: a
         type(surface_type), intent(in) :: b
         !> Whether the first of the row is surface A.
         logical, intent(in) :: first_is_a
         class(geometry_type), allocatable, intent(out) :: geometry
      end subroutine pair_interface
   end interface

   !> A row of the table: shapes, and the way to their closest points.
   type :: pair_type
      !> Shape of one surface, which is touched from outside; blank for any.
      character(len=16) :: first = ""
      !> Shape of the other one; blank for any.
      character(len=16) :: second = ""
      !> What the pair is; blank for what follows from the shapes.
      character(len=80) :: summary = ""
      !> How the closest points are found; blank for how the point of the second shape is found
      !> that is closest to a given one.
      character(len=56) :: way = ""
      procedure(pair_interface), pointer, nopass :: new => null()
   end type pair_type

contains

   !> The table; the first row that fits a pair counts.
   function pair_table() result(rows)
      type(pair_type) :: rows(6)

      rows(1) = pair_type("sphere", "plane", "sphere against plane, in either order; circular " // &
         "spot of relative radius R", "closed form", new_sphere_plane)
      rows(2) = pair_type("sphere", "sphere", "two spheres, one of them perhaps a socket; " // &
         "circular spot", "closed form", new_ball_pair)
      rows(3) = pair_type("sphere", "", "", "", new_ball_pair)
      rows(4) = pair_type("", "plane", "", "closed form", new_support_pair)
      rows(5) = pair_type("cylinder", "cylinder", "two cylinders at an angle; parallel they " // &
         "conform", "closed form", new_axes_pair)
      rows(6) = pair_type("", "", "", "search for the common normal of implicit surfaces", &
         new_searched_pair)
   end function pair_table

   !> Geometry of a pair of surfaces; unallocated when the pair cannot touch in a point.
   subroutine new_geometry(a, b, geometry, problem)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      class(geometry_type), allocatable, intent(out) :: geometry
      !> Why the pair is refused; unallocated when it is not.
      character(len=:), allocatable, intent(out), optional :: problem
      type(pair_type) :: rows(6)
      character(len=:), allocatable :: reason
      logical :: first_is_a
      integer :: i

      reason = refusal(a, b)
      if (reason /= "") then
         if (present(problem)) problem = reason
         return
      end if
      rows = pair_table()
      call find_row(rows, a, b, i, first_is_a)
      call rows(i)%new(a, b, first_is_a, geometry)
   end subroutine new_geometry

   !> The row of a pair.
   pure subroutine find_row(rows, a, b, i, first_is_a)
      type(pair_type), intent(in) :: rows(:)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      integer, intent(out) :: i
      !> Whether the first of the row is surface A.
      logical, intent(out) :: first_is_a
      type(shape_info_type) :: one, other

      one = a%shape%info()
      other = b%shape%info()
      do i = 1, size(rows)
         first_is_a = .not. a%inside .and. fits(one, other)
         if (first_is_a .or. .not. b%inside .and. fits(other, one)) return
      end do

   contains

      !> Whether a row is about two shapes in this order.
      pure logical function fits(first, second)
         type(shape_info_type), intent(in) :: first
         type(shape_info_type), intent(in) :: second

         fits = (rows(i)%first == "" .or. rows(i)%first == first%name) &
            .and. (rows(i)%second == "" .or. rows(i)%second == second%name)
      end function fits

   end subroutine find_row

   !> Why two surfaces cannot touch in a point; empty when they can.
   pure function refusal(a, b) result(text)
      type(surface_type), intent(in) :: a
      type(surface_type), intent(in) :: b
      character(len=:), allocatable :: text
      type(shape_info_type) :: info_a, info_b

      info_a = a%shape%info()
      info_b = b%shape%info()
      text = ""
      if (a%inside .and. b%inside) then
         text = a%words() // " and " // b%words() // " are both concave and never touch"
      else if (a%inside) then
         text = b%shape%misfit(a%shape)
      else if (b%inside) then
         text = a%shape%misfit(b%shape)
      else if (info_b%name == "plane") then
         text = trim(info_a%on_plane)
      else if (info_a%name == "plane") then
         text = trim(info_b%on_plane)
      else if (min(a%shape%smallest_radius(), b%shape%smallest_radius()) >= huge(1.0_wp)) then
         text = a%words() // " and " // b%words() // " have no radius to compare an overlap with"
      else if (max(carrier_rank(a), carrier_rank(b)) == 0) then
         text = a%words() // " and " // b%words() // " have no search for their closest points"
      end if
   end function refusal

   !> Pairs of shapes that can touch.
   function geometry_models() result(models)
      type(model_info_type), allocatable :: models(:)
      type(shape_list_type), pointer :: list
      type(surface_type), allocatable :: surfaces(:)
      type(pair_type) :: rows(6)
      type(shape_info_type) :: one, other
      logical :: first
      integer :: i, j, k, n, row

      rows = pair_table()
      list => shared_shapes()
      allocate(surfaces(list%n), models(list%n**2))
      do i = 1, list%n
         allocate(surfaces(i)%shape, source=list%items(i)%shape)
      end do
      n = 0
      do k = 1, size(rows)
         do i = 1, size(surfaces)
            one = surfaces(i)%shape%info()
            do j = 1, size(surfaces)
               other = surfaces(j)%shape%info()
               if (refusal(surfaces(i), surfaces(j)) /= "") cycle
               call find_row(rows, surfaces(i), surfaces(j), row, first)
               if (row /= k .or. .not. first) cycle
               ! What ends comes first, else what is first in the list of shapes.
               if (k == size(rows) .and. .not. (one%bounded .and. .not. other%bounded .or. &
                  (one%bounded .eqv. other%bounded) .and. i <= j)) cycle
               n = n + 1
               models(n) = model_info_type(trim(one%name) // ", " // other%name, &
                  summary(rows(k), surfaces(i)%shape, surfaces(j)%shape), "surfaces", rows(k)%way)
               if (rows(k)%way == "") models(n)%reference = other%way
            end do
         end do
      end do
      models = models(:n)
   end function geometry_models

   !> What a pair is.
   function summary(row, first, second) result(text)
      type(pair_type), intent(in) :: row
      class(shape_type), intent(in) :: first
      class(shape_type), intent(in) :: second
      character(len=:), allocatable :: text
      type(shape_info_type) :: one, other

      one = first%info()
      other = second%info()
      text = trim(row%summary)
      if (text /= "") return
      if (other%name == "plane") then
         text = trim(one%name) // " against plane"
         if (one%remark /= "") text = text // "; " // trim(one%remark)
         return
      end if
      text = trim(one%name) // " on " // second%words()
      if (one%name == other%name) text = "two " // trim(one%plural)
      if (other%hollow == "" .or. .not. (one%bounded .or. one%slender .and. other%widens)) return
      if (one%name == other%name) then
         text = text // ", one of them perhaps a " // trim(other%hollow)
      else
         text = text // " or in a " // trim(other%hollow) // ", the inside of one"
      end if
   end function summary

end module contensou_contact_pairs
