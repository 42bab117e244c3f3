!> Laws of creep: what is prepared for a spot that stays the same gives the wrench of one that is
!> met once; and the angles that they take without a library.
module test_creep
   use contensou_base_kinds, only : pi, wp
   use contensou_contact_creep, only : creep_model_type, creep_models, creep_type
   use contensou_contact_creep_law, only : creep_motion_type, creep_spot, creep_spot_type, &
      settled_spot
   use contensou_contact_spot, only : elliptic_shape
   use contensou_special_angle, only : largest_small, quadrant_angle, small_turn
   use test_harness, only : check_close, random_type, worst_type
   implicit none(type, external)
   private

   public :: run_creep_tests

contains

   !> All tests of this suite.
   subroutine run_creep_tests()
      call test_angles()
      call test_settled_spots()
   end subroutine run_creep_tests

   !> Angles of unit vectors, and rotations, against functions of the library.
   subroutine test_angles()
      integer, parameter :: n = 10000
      type(random_type) :: random
      type(worst_type) :: absolute, relative, turned
      real(wp) :: angle, c, s
      integer :: i

      do i = 1, n
         angle = 0.5_wp*pi*real(i, wp)/real(n, wp)
         s = sin(angle)
         c = cos(angle)
         call absolute%note(abs(quadrant_angle(c, s, s*s) - angle), i)
         call absolute%note(abs(quadrant_angle(s, c, c*c) - (0.5_wp*pi - angle)), i)
         angle = 10.0_wp**random%uniform(-150.0_wp, 0.0_wp)
         call relative%note(abs(quadrant_angle(cos(angle), sin(angle), sin(angle)**2)/angle &
            - 1.0_wp), i)
         angle = random%uniform(0.0_wp, largest_small)
         call small_turn(angle, c, s)
         call turned%note(max(abs(c - cos(angle)), abs(s - sin(angle))), i)
      end do
      call absolute%check_below(4.0_wp*epsilon(angle), "angles of unit vectors")
      call relative%check_below(4.0_wp*epsilon(angle), "small angles of unit vectors")
      call turned%check_below(epsilon(angle), "small rotations")
      call check_close(quadrant_angle(0.0_wp, 1.0_wp, 1.0_wp), 0.5_wp*pi, 0.0_wp, &
         "the angle of the y axis")
   end subroutine test_angles

   !> Wrenches of random spots, beyond the table of ratios too, rolling along axes and between them.
   subroutine test_settled_spots()
      type(creep_model_type), allocatable :: models(:)
      class(creep_type), allocatable :: law
      type(creep_spot_type) :: spot
      type(creep_motion_type) :: motion
      type(random_type) :: random
      type(worst_type) :: worst
      real(wp) :: one(3), other(3), e(3), v(3)
      integer :: i, j

      models = creep_models()
      do i = 1, size(models)
         ! As it takes 0.1 s, and nothing is prepared for it.
         if (models(i)%info%name == "boundary_elements") cycle
         worst = worst_type()
         call models(i)%make(law)
         do j = 1, 300
            spot = creep_spot(elliptic_shape(10.0_wp**random%uniform(-1.5_wp, 0.0_wp)), 0.3_wp, &
               8.0e10_wp, random%uniform(0.0_wp, 0.5_wp))
            e = random%vector(3)
            if (mod(j, 10) == 0) e(1) = 0.0_wp
            if (mod(j, 10) == 5) e(2) = 0.0_wp
            v = random%vector(3)*10.0_wp**random%uniform(-2.0_wp, 2.0_wp)
            motion = creep_motion_type(v(1), v(2), v(3), e(1), e(2))
            call law%kernel(spot, motion, one)
            call law%kernel(settled_spot(spot), motion, other)
            call worst%note(maxval(abs(one - other))/max(1.0_wp, maxval(abs(one))), j)
         end do
         call worst%check_below(2.0e-14_wp, "creep: a spot that stays the same, by " // &
            trim(models(i)%info%name))
      end do
   end subroutine test_settled_spots

end module test_creep
