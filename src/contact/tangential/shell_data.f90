!> The numbers of the nested shells of a contact with tangential elasticity, apart from what is done
!> with them, so that kernels for all registers may know them.
module contensou_contact_tangential_shell_data
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: shell_data_type, block

   !> Shells that loops over all take at a time.
   integer, parameter :: block = 8

   !> The shells of a contact, from the centre to the rim, with what they remember. Behind the last
   !> one there is room for more than a block, whose numbers are finite, without a meaning.
   type :: shell_data_type
      !> Number of shells when the spot has a size.
      integer :: most = 0
      !> Number of shells now, zero without a contact, and the one aimed at.
      integer :: n = 0, aim = 0
      !> Major semi-axis [m].
      real(wp) :: a = 0.0_wp
      !> k_x, k_y and k_T of the spot.
      real(wp) :: stiffness(3) = 0.0_wp
      !> Way of shift and twist, over those at which all slides, and the size [m] where it began.
      real(wp) :: way = 0.0_wp, size_of_way = 0.0_wp
      !> Shells of the area by which it may grow in the next step.
      integer :: new = 1
      !> Outer edges along the major axis [m], from 0 on, and their powers 2/3.
      real(wp), allocatable :: edge(:), power(:)
      !> What is within them (`contensou_contact_tangential_edges`).
      real(wp), allocatable :: load(:), size(:), torsion(:)
      !> Stiffness of each shell along the axes and about the normal.
      real(wp), allocatable :: share(:, :)
      !> Elastic displacements of the shells along the axes [m] and about the normal [rad].
      real(wp), allocatable :: shift(:, :)
      !> Energy of their twist beyond that of an even one [J], with the sign of the twist. A shell
      !> that becomes stiffer has new area, which is not strained; that goes first where the shell
      !> becomes softer again.
      real(wp), allocatable :: uneven(:)
      !> Directions of their last slips, or zero: where the next slip is sought first.
      real(wp), allocatable :: direction(:, :)
      !> By how much the forces of trials are outside of what surely sticks.
      real(wp), allocatable :: excess(:)
      !> Which slipped in the last step; one for those that slipped in the step before that, else
      !> zero.
      logical, allocatable :: slipped(:)
      real(wp), allocatable :: slid(:)
      !> What rolling leaves of slip about the normal within the step at hand, over what it leaves
      !> of slip along the surface.
      real(wp) :: fading = 1.0_wp
      !> What shells that slip on have of the step at hand besides, along the axes [m] and about the
      !> normal: its direction is that at its end then.
      real(wp) :: turning(3) = 0.0_wp
      !> The axis along and across which the displacements have their components, seen from the
      !> axes of the spot where `stiffness` was.
      real(wp) :: axis(2) = [1.0_wp, 0.0_wp]
      !> Direction of the last step of an elliptic spot, of shift and twist times the semi-axis, or
      !> zero. Those of slips turn as it does, about.
      real(wp) :: went(3) = 0.0_wp
   end type shell_data_type

end module contensou_contact_tangential_shell_data
