!> Values of the keys of the models of a contact, by name, and what else a model is made from.
module contensou_contact_parameters
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: parameters_type, surroundings_type

   !> A value; a logical is 0 or 1, a choice its position in its table.
   type :: parameter_type
      character(len=28) :: name = ""
      real(wp) :: value(3) = 0.0_wp
   end type parameter_type

   !> Values by name.
   type :: parameters_type
      !> Whether all keys that have a default have a value.
      logical :: complete = .false.
      type(parameter_type), allocatable, private :: items(:)
   contains
      !> Give a key a number or a logical.
      generic :: set => set_number, set_numbers, set_flag
      procedure, private :: set_number
      procedure, private :: set_numbers
      procedure, private :: set_flag
      procedure :: has
      procedure :: number
      procedure :: numbers
      procedure :: flag
   end type parameters_type

   !> The two bodies and materials that a contact is between.
   type :: surroundings_type
      !> Young's moduli [Pa].
      real(wp) :: young(2) = 0.0_wp
      !> Poisson's ratios [-].
      real(wp) :: poisson(2) = 0.0_wp
      !> Effective modulus E* [Pa].
      real(wp) :: modulus = 0.0_wp
      !> Half relative curvatures A <= B at the beginning [1/m].
      real(wp) :: curvatures(2) = 0.0_wp
      !> Reduced mass [kg].
      real(wp) :: mass = 0.0_wp
      !> Whether the shape of the spot is needed.
      logical :: with_shape = .true.
   end type surroundings_type

contains

   !> Give a key numbers, up to three.
   pure subroutine set_numbers(self, name, x)
      class(parameters_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: x(:)
      type(parameter_type), allocatable :: longer(:)
      integer :: i, n

      i = place(self, name)
      if (i == 0) then
         n = 0
         if (allocated(self%items)) n = size(self%items)
         i = n + 1
         allocate(longer(i))
         if (n > 0) longer(:n) = self%items
         longer(i)%name = name
         call move_alloc(longer, self%items)
      end if
      n = min(size(x), 3)
      self%items(i)%value(:n) = x(:n)
   end subroutine set_numbers

   !> Give a key a number.
   pure subroutine set_number(self, name, x)
      class(parameters_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: x

      call self%set_numbers(name, [x])
   end subroutine set_number

   !> Give a key a logical.
   pure subroutine set_flag(self, name, x)
      class(parameters_type), intent(inout) :: self
      character(len=*), intent(in) :: name
      logical, intent(in) :: x

      call self%set_numbers(name, [merge(1.0_wp, 0.0_wp, x)])
   end subroutine set_flag

   !> Position of a key; 0 if it has no value.
   pure integer function place(self, name)
      type(parameters_type), intent(in) :: self
      character(len=*), intent(in) :: name

      place = 0
      if (.not. allocated(self%items)) return
      do place = size(self%items), 1, -1
         if (self%items(place)%name == name) return
      end do
   end function place

   !> Whether a key has a value.
   pure logical function has(self, name)
      class(parameters_type), intent(in) :: self
      character(len=*), intent(in) :: name

      has = place(self, name) > 0
   end function has

   !> Number of a key; another one, or zero, if it has none.
   pure real(wp) function number(self, name, otherwise)
      class(parameters_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp), intent(in), optional :: otherwise
      integer :: i

      number = 0.0_wp
      if (present(otherwise)) number = otherwise
      i = place(self, name)
      if (i > 0) number = self%items(i)%value(1)
   end function number

   !> Three numbers of a key; zero if it has none.
   pure function numbers(self, name) result(x)
      class(parameters_type), intent(in) :: self
      character(len=*), intent(in) :: name
      real(wp) :: x(3)
      integer :: i

      x = 0.0_wp
      i = place(self, name)
      if (i > 0) x = self%items(i)%value
   end function numbers

   !> Logical of a key; .false. if it has none.
   pure logical function flag(self, name)
      class(parameters_type), intent(in) :: self
      character(len=*), intent(in) :: name

      flag = self%number(name) > 0.0_wp
   end function flag

end module contensou_contact_parameters
