!> Exact wrenches of steady rolling along an axis of the spot, for scripts/generate_creep.py.
!>
!> Reads the elements across the finer lattice, then lines of a/b with a along the rolling
!> direction, Poisson's ratio, and the creepages in e0 (spin times sqrt(a b)); writes the forces in
!> f N and the torque in f N sqrt(a b). Neighbouring lines are best alike: the tractions of one are
!> the guess for the next.
program creep_nodes
   use, intrinsic :: iso_fortran_env, only : input_unit, output_unit
   use contensou_base_kinds, only : wp
   use contensou_contact_creep_boundary_elements, only : elements_type, new_elements, roll
   use contensou_contact_spot, only : elliptic_shape
   use contensou_contact_wrench, only : slip_type, wrench_exact
   implicit none(type, external)
   type(elements_type) :: elements
   real(wp) :: ratio, poisson, creepage(3), sliding(3), wrench(3), last(2), k, root
   integer :: n, status

   read(input_unit, *) n
   last = -1.0_wp
   do
      read(input_unit, *, iostat=status) ratio, poisson, creepage
      if (status /= 0) exit
      if (any(abs([ratio, poisson] - last) > 0.0_wp)) then
         elements = new_elements([n/2, n], sqrt(ratio), 0.0_wp, poisson)
         last = [ratio, poisson]
      end if
      k = min(ratio, 1.0_wp/ratio)
      root = sqrt(k)
      if (ratio >= 1.0_wp) then
         call wrench_exact(elliptic_shape(k), slip_type(creepage(1), creepage(2), &
            creepage(3)/root), .true., sliding)
      else
         ! The major axis is across.
         call wrench_exact(elliptic_shape(k), slip_type(creepage(2), -creepage(1), &
            creepage(3)/root), .true., sliding)
         sliding(:2) = [-sliding(2), sliding(1)]
      end if
      sliding(3) = sliding(3)/root
      call roll(elements, creepage, sliding, wrench)
      write(output_unit, "(3es24.15)") wrench
   end do
end program creep_nodes
