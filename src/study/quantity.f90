!> What a row of an output file is made of: a quantity with its name, dimensions, units and text,
!> and the procedure that takes its values from a moment of a motion.
module contensou_study_quantity
   use contensou_base_errors, only : error_type, fatal
   use contensou_base_kinds, only : wp
   use contensou_contact_geometry, only : pose_type
   use contensou_dynamics_scene, only : turns_by_drive
   use contensou_dynamics_equations, only : system_type
   use contensou_dynamics_reports, only : begin_report, contact_report_type, drive_loads, &
      energies, report_contact
   use contensou_dynamics_springs, only : spring_load_type
   implicit none(type, external)
   private

   public :: quantity_type, moment_type
   public :: of_none, of_bodies, of_contacts, of_springs
   public :: always, if_driven, if_geometry, if_memory, if_states, if_curvatures_vary, if_rolling, &
      if_springs, if_curved

   !> When a quantity is there: in every scene, or only if a body is driven, rows are to have the
   !> geometry of contacts, a contact has tangential elasticity, the state that the quantity is, or
   !> surfaces whose curvatures vary, rows are to tell what rolls, there are springs, or
   !> spots are curved.
   integer, parameter :: always = 0, if_driven = 1, if_geometry = 2, if_memory = 3, if_states = 4, &
      if_curvatures_vary = 5, if_rolling = 6, if_springs = 7, if_curved = 8

   !> What a quantity belongs to.
   integer, parameter :: of_none = 0, of_bodies = 1, of_contacts = 2, of_springs = 3

   !> All that is known of a motion at a time; procedures of quantities take their values from it.
   type :: moment_type
      !> The equations of motion, with the properties of bodies and contacts.
      type(system_type), pointer :: system => null()
      !> Time [s].
      real(wp) :: t = 0.0_wp
      real(wp), allocatable :: y(:)
      !> Position, attitude and velocities of the bodies.
      type(pose_type), allocatable :: pose(:)
      !> Attitude, body to inertial frame, (4, bodies).
      real(wp), allocatable :: quaternion(:, :)
      type(contact_report_type), allocatable :: contact(:)
      !> What the springs do.
      type(spring_load_type), allocatable :: spring(:)
      !> What keeps a prescribed motion: force [N] and torque about the centre of mass [N m], (3,
      !> bodies); not set unless a body is driven.
      real(wp), allocatable :: drive_force(:, :), drive_torque(:, :)
      !> Energies [J].
      real(wp) :: kinetic = 0.0_wp, potential = 0.0_wp, elastic = 0.0_wp, springs = 0.0_wp
      !> Work so far [J].
      real(wp) :: work_friction = 0.0_wp, work_damping = 0.0_wp, work_applied = 0.0_wp
      !> Residual of the energy balance since the beginning [J]; the summary knows the beginning.
      real(wp) :: energy_error = 0.0_wp
   contains
      procedure :: look_at_bodies
      procedure :: look
      procedure :: balance
   end type moment_type

   !> A quantity of a row.
   type :: quantity_type
      character(len=31) :: name
      !> Dimensions after time, separated by a blank: `body`, `contact` or `spring`, then `xyz`,
      !> `wxyz` or `axis`; blank for one number.
      character(len=12) :: dims
      !> UDUNITS text.
      character(len=8) :: units
      character(len=128) :: long_name
      !> Fills the components of a body, contact or spring.
      procedure(fill_interface), pointer :: fill => null()
      !> Description in the summary, of the value at the end; blank if it is not in there.
      character(len=64) :: final = ""
      !> When it is there.
      integer :: there = always
      !> Number of components per body, contact or spring, from `dims`.
      integer :: components = 1
      !> What it belongs to, from `dims`: one of the `of_*` codes.
      integer :: of = of_none
      !> Whether it is in the summary.
      logical :: at_end = .false.
   contains
      procedure :: set_width
      !> What it belongs to: `body`, `contact`, `spring` or nothing.
      procedure :: owner
   end type quantity_type

   abstract interface
      !> Values of a quantity.
      subroutine fill_interface(self, at, i, values)
         import :: moment_type, quantity_type, wp
         implicit none(type, external)
         class(quantity_type), intent(in) :: self
         type(moment_type), intent(in) :: at
         !> Number of the body, contact or spring; 1 for a quantity of none.
         integer, intent(in) :: i
         !> Its components.
         real(wp), intent(out) :: values(:)
      end subroutine fill_interface
   end interface

contains

   !> Set what follows from the dimensions and the text at the end.
   elemental subroutine set_width(self)
      class(quantity_type), intent(inout) :: self

      select case (self%owner())
      case ("body")
         self%of = of_bodies
      case ("contact")
         self%of = of_contacts
      case ("spring")
         self%of = of_springs
      case default
         self%of = of_none
      end select
      select case (self%dims(scan(self%dims, " ") + 1:))
      case ("axis")
         self%components = 2
      case ("xyz")
         self%components = 3
      case ("wxyz")
         self%components = 4
      case default
         self%components = 1
      end select
      self%at_end = self%final /= ""
   end subroutine set_width

   pure function owner(self)
      class(quantity_type), intent(in) :: self
      character(len=7) :: owner

      owner = self%dims(:scan(self%dims, " ") - 1)
   end function owner

   !> Take the bodies of a state.
   subroutine look_at_bodies(self, system, t, y)
      class(moment_type), intent(inout) :: self
      type(system_type), intent(in), target :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      integer :: i

      if (.not. allocated(self%pose)) allocate(self%pose(size(system%bodies)), &
         self%quaternion(4, size(system%bodies)))
      self%system => system
      self%t = t
      self%y = y
      do i = 1, size(system%bodies)
         call system%pose_of(y, i, self%pose(i), self%quaternion(:, i))
      end do
   end subroutine look_at_bodies

   !> Take all of a state, apart from the energy error.
   subroutine look(self, system, t, y, error)
      class(moment_type), intent(inout) :: self
      !> The equations of motion; their workspace is changed.
      type(system_type), intent(inout), target :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      !> Set where the forces of rigid contacts are not found: nothing is known then.
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: stored_friction, stored_damping
      integer :: i

      call self%look_at_bodies(system, t, y)
      if (.not. allocated(self%contact)) allocate(self%contact(size(system%contacts)), &
         self%spring(size(system%springs)))
      self%elastic = 0.0_wp
      call begin_report(system, t, y)
      if (system%outside) then
         call fatal(error, "the forces of the rigid contacts are not found")
         return
      end if
      do i = 1, size(system%contacts)
         call report_contact(system, i, self%contact(i))
         self%elastic = self%elastic + self%contact(i)%elastic_energy
      end do
      stored_friction = sum(self%contact%stored_friction)
      stored_damping = sum(self%contact%stored_damping)
      if (any(turns_by_drive(system%bodies%motion))) then
         if (.not. allocated(self%drive_force)) allocate(self%drive_force(3, &
            size(system%bodies)), self%drive_torque(3, size(system%bodies)))
         call drive_loads(system, self%drive_force, self%drive_torque)
      end if
      do i = 1, size(system%springs)
         associate (spring => system%springs(i))
            call spring%load(system%pose(spring%a), system%pose(spring%b), self%spring(i))
         end associate
      end do
      self%springs = sum(self%spring%energy)
      self%elastic = self%elastic + self%springs
      call energies(system, y, self%kinetic, self%potential)
      ! What the states of parts store is not lost.
      self%work_friction = work(system%layout%friction) - stored_friction
      self%work_damping = work(system%layout%damping) - stored_damping
      self%elastic = self%elastic + stored_friction + stored_damping
      self%work_applied = work(system%layout%applied)
      self%energy_error = 0.0_wp

   contains

      !> A work of the state [J].
      pure real(wp) function work(place)
         !> Its index; 0 for none.
         integer, intent(in) :: place

         work = 0.0_wp
         if (place > 0) work = y(place)
      end function work

   end subroutine look

   !> Energy less what was supplied, plus what was lost [J].
   pure real(wp) function balance(self)
      class(moment_type), intent(in) :: self

      balance = self%kinetic + self%potential + self%elastic + self%work_friction + &
         self%work_damping - self%work_applied
   end function balance

end module contensou_study_quantity
