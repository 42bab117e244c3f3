!> What is asked of the equations of motion beside their right-hand side: the state of a contact,
!> the forces of the drives, energies and momenta.
!>
!> `begin_report` sets poses and the normal forces of rigid contacts once for all that is told of a
!> state.
module contensou_dynamics_reports
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_kinds, only : wp
   use contensou_base_rotations, only : rotation_matrix
   use contensou_base_vectors, only : cross
   use contensou_contact_geometry, only : contact_motion_type, contact_point_type, &
      contact_variation_type, rolling_velocity, trouble_none
   use contensou_contact_law, only : contact_load_type
   use contensou_contact_states, only : most_states
   use contensou_contact_tangential_memory, only : unit_axis
   use contensou_dynamics_equations, only : add_contacts, add_springs, system_type
   use contensou_dynamics_mechanism, only : contact_type, mechanism_type, relative_motion, &
      slip_velocity
   use contensou_dynamics_scene, only : motion_free, motion_prescribed, motion_rotor, &
      moves_freely, turns_by_drive
   use contensou_dynamics_springs, only : spring_load_type
   use contensou_dynamics_state, only : position_of, quaternion_of, spin_of, velocity_of
   implicit none(type, external)
   private

   public :: contact_report_type, begin_report, report_contact, drive_loads, momenta
   public :: energy_type, energies, find_energy, rolling_of, creepages

   !> What an output row says of a contact.
   type :: contact_report_type
      !> Geometry.
      type(contact_point_type) :: at
      !> Load, zero when open.
      type(contact_load_type) :: load
      !> Slip velocity of B against A in the tangent plane [m/s], inertial frame; zero when open.
      real(wp) :: slip(3) = 0.0_wp
      !> Spin of B against A about the normal [rad/s], zero when open.
      real(wp) :: spin = 0.0_wp
      !> Semi-axes of the spot [m], zero when open.
      real(wp) :: semi_axes(2) = 0.0_wp
      !> Elastic energy of the spot [J].
      real(wp) :: elastic_energy = 0.0_wp
      !> Force on B [N] and torque about the contact point [N m] by which the elastic energy resists
      !> a change of the curvatures, inertial frame.
      real(wp) :: curvature_force(6) = 0.0_wp
      !> Energy stored in the states of damping and friction [J]: of what these took, so much is not
      !> lost.
      real(wp) :: stored_damping = 0.0_wp, stored_friction = 0.0_wp
      !> Elastic energy of shear and twist, part of `stored_friction` [J].
      real(wp) :: stored_tangential = 0.0_wp
      !> Share of the spot that sticks [-], with tangential elasticity.
      real(wp) :: stuck = 0.0_wp
      !> Elastic tangential displacement of B against A [m], inertial frame.
      real(wp) :: displacement(3) = 0.0_wp
   end type contact_report_type

   !> Where the energy is.
   type :: energy_type
      !> Energies of the bodies, and elastic energy of contacts [J].
      real(wp) :: kinetic = 0.0_wp, potential = 0.0_wp, elastic = 0.0_wp
      !> Work so far: lost, or stored by states of parts; supplied [J].
      real(wp) :: friction = 0.0_wp, damping = 0.0_wp, applied = 0.0_wp
      !> What of the work of friction is stored [J].
      real(wp) :: stored = 0.0_wp
   contains
      procedure :: total
   end type energy_type

contains

   !> Energy with what was lost and without what was supplied [J]: constant.
   pure real(wp) function total(self)
      class(energy_type), intent(in) :: self

      total = self%kinetic + self%potential + self%elastic + self%friction + self%damping &
         - self%applied
   end function total

   !> Where the energy of a state is.
   subroutine find_energy(system, t, y, energy)
      !> The system; its workspace is changed.
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)
      type(energy_type), intent(out) :: energy
      type(contact_report_type) :: row
      integer :: i

      call begin_report(system, t, y)
      do i = 1, size(system%contacts)
         call report_contact(system, i, row)
         energy%elastic = energy%elastic + row%elastic_energy
         energy%stored = energy%stored + row%stored_friction
      end do
      energy%elastic = energy%elastic + spring_energy(system)
      call energies(system, y, energy%kinetic, energy%potential)
      ! What the states of parts store is part of the works.
      associate (layout => system%layout)
         if (layout%friction > 0) energy%friction = y(layout%friction)
         if (layout%damping > 0) energy%damping = y(layout%damping)
         if (layout%applied > 0) energy%applied = y(layout%applied)
      end associate
   end subroutine find_energy

   !> Energy that the springs store at the poses that are set [J].
   pure real(wp) function spring_energy(mechanism) result(energy)
      class(mechanism_type), intent(in) :: mechanism
      type(spring_load_type) :: found
      integer :: i

      energy = 0.0_wp
      do i = 1, size(mechanism%springs)
         associate (spring => mechanism%springs(i))
            call spring%load(mechanism%pose(spring%a), mechanism%pose(spring%b), found)
         end associate
         energy = energy + found%energy
      end do
   end function spring_energy

   !> Set poses, and normal forces of the closed rigid contacts, for reports on a state.
   subroutine begin_report(system, t, y)
      type(system_type), intent(inout) :: system
      !> Time [s].
      real(wp), intent(in) :: t
      real(wp), intent(in) :: y(:)

      call system%constraint_forces(t, y)
      call system%set_poses(y)
      if (system%layout%states > 0) call system%set_states(y)
   end subroutine begin_report

   !> All that an output row says of a contact, after `begin_report`.
   subroutine report_contact(system, index, row)
      !> The system; its workspace is changed.
      type(system_type), intent(inout) :: system
      integer, intent(in) :: index
      type(contact_report_type), intent(out) :: row
      type(contact_motion_type) :: now
      real(wp) :: resolution
      integer :: trouble

      call system%observe(index, now)
      row%at = now%at
      if (system%contacts(index)%track%away) then
         row%at%gap = ieee_value(row%at%gap, ieee_quiet_nan)
         return
      end if
      associate (contact => system%contacts(index), law => system%contacts(index)%law)
         if (contact%track%lost) return
         if (contact%rigid) then
            if (contact%closed .and. .not. system%outside) call report_rigid(system, index, row)
            return
         end if
         if (row%at%gap >= 0.0_wp) return
         call contact%follow(row%at, trouble)
         if (trouble /= trouble_none) return
         if (allocated(law%curved)) call contact%bend(system%pose(contact%a), &
            system%pose(contact%b), row%at)
         resolution = system%resolution%of(system%pose(contact%a), system%pose(contact%b), &
            row%at%point)
         if (contact%evolves) then
            call contact%evolve(system%pose(contact%a), system%pose(contact%b), now, resolution, &
               row%load)
            call contact%stored_energies(row%at, -row%at%gap, [dot_product(now%velocity, &
               row%at%major), dot_product(now%velocity, cross(row%at%normal, row%at%major)), &
               dot_product(now%spin, row%at%normal)], row%load%normal_force, row%stored_damping, &
               row%stored_friction)
            if (allocated(contact%tangential)) call report_tangential(contact, row)
         else
            call law%evaluate(now, resolution, row%load)
         end if
         row%slip = slip_velocity(now%velocity, row%at%normal)
         row%spin = dot_product(now%spin, row%at%normal)
         row%semi_axes = [law%normal%major_axis(-row%at%gap), law%normal%minor_axis(-row%at%gap)]
         row%elastic_energy = law%normal%energy(-row%at%gap)
         if (contact%curvatures_vary()) call contact%shape_force(system%pose(contact%a), &
            system%pose(contact%b), row%at, row%curvature_force)
      end associate
   end subroutine report_contact

   !> Report on tangential elasticity.
   subroutine report_tangential(contact, row)
      !> The contact, its load just evaluated.
      type(contact_type), intent(inout) :: contact
      type(contact_report_type), intent(inout) :: row
      real(wp) :: local(most_states), axis(2), along(3), across(3), displacement(2)

      call contact%tangential%tell(row%stored_tangential, row%stuck, displacement)
      row%stored_friction = row%stored_tangential
      local = contact%local_states(row%at)
      axis = unit_axis(local(contact%states%n_damping + 1:contact%states%n_damping + 2))
      along = axis(1)*row%at%major + axis(2)*cross(row%at%normal, row%at%major)
      across = cross(row%at%normal, along)
      row%displacement = displacement(1)*along + displacement(2)*across
   end subroutine report_tangential

   !> Report on a closed rigid contact.
   subroutine report_rigid(system, index, row)
      !> The system, its normal forces those of the state.
      type(system_type), intent(inout) :: system
      integer, intent(in) :: index
      type(contact_report_type), intent(inout) :: row
      real(wp) :: approach
      integer :: i

      do i = 1, system%constraints%n_links
         if (system%constraints%links(i)%contact /= index) cycle
         associate (link => system%constraints%links(i), law => system%contacts(index)%law)
            ! Below zero by rounding at lift-off, and where others hold the gap.
            row%load%normal_force = link%normal_force
            row%load%friction_force = link%wrench(1:3) - link%normal_force*link%at%normal
            row%load%friction_torque = dot_product(link%wrench(4:6), link%at%normal)
            row%load%rolling_torque = link%wrench(4:6) - row%load%friction_torque*link%at%normal
            row%slip = link%slip()
            row%spin = link%motion(3)
            row%load%friction_power = -dot_product(link%wrench(1:3), row%slip) &
               - dot_product(link%wrench(4:6), link%spin)
            approach = law%normal%approach(max(link%normal_force, 0.0_wp))
            row%semi_axes = [law%normal%major_axis(approach), law%normal%minor_axis(approach)]
            if (system%contacts(index)%states%n > 0) call system%contacts(index)%stored_energies( &
               row%at, approach, link%motion, row%load%normal_force, row%stored_damping, &
               row%stored_friction)
            if (allocated(system%contacts(index)%tangential)) call report_tangential( &
               system%contacts(index), row)
         end associate
      end do
   end subroutine report_rigid

   !> Rolling velocity of a contact that was reported, inertial frame [m/s]; zero without a spot.
   pure function rolling_of(system, index, row) result(rolling)
      !> The system at the poses of the report.
      type(system_type), intent(in) :: system
      integer, intent(in) :: index
      type(contact_report_type), intent(in) :: row
      real(wp) :: rolling(3)
      type(contact_variation_type) :: variation
      real(wp) :: velocity(3), spin(3)

      rolling = 0.0_wp
      if (.not. row%semi_axes(1) > 0.0_wp) return
      associate (contact => system%contacts(index), a => system%pose(system%contacts(index)%a), &
         b => system%pose(system%contacts(index)%b))
         call relative_motion(a, b, row%at%point, velocity, spin)
         call contact%law%geometry%vary(a, b, contact%track, row%at, variation)
         rolling = slip_velocity(rolling_velocity(variation, velocity, spin), row%at%normal)
      end associate
   end function rolling_of

   !> Creepages of a contact that was reported: slip velocity along the direction of rolling and
   !> along normal x that direction, both over the rolling velocity [-], and spin over the rolling
   !> velocity [1/m]; not a number where nothing rolls.
   pure function creepages(row, rolling) result(creep)
      type(contact_report_type), intent(in) :: row
      !> Its rolling velocity [m/s].
      real(wp), intent(in) :: rolling(3)
      real(wp) :: creep(3)
      real(wp) :: speed, ahead(3)

      speed = norm2(rolling)
      if (.not. speed > 0.0_wp) then
         creep = ieee_value(creep, ieee_quiet_nan)
         return
      end if
      ahead = -rolling/speed
      creep = [dot_product(row%slip, ahead), dot_product(row%slip, cross(row%at%normal, ahead)), &
         row%spin]/speed
   end function creepages

   !> What the drives supply against contacts and springs, after `begin_report`: the force on a body
   !> whose motion is prescribed, the torque about the centre of mass of any body whose rotation is
   !> prescribed; zero for others. The inertia of the driven bodies is not counted.
   subroutine drive_loads(system, force, torque)
      !> The system; its workspace is changed.
      type(system_type), intent(inout) :: system
      !> Force on each body [N], inertial frame.
      real(wp), intent(out) :: force(:, :)
      !> Torque on each body [N m], inertial frame.
      real(wp), intent(out) :: torque(:, :)
      real(wp) :: friction_power, damping_power, on_body(3), about_body(3)
      integer :: i, j

      do i = 1, size(system%bodies)
         system%load(i)%force = 0.0_wp
         system%load(i)%torque = 0.0_wp
      end do
      friction_power = 0.0_wp
      damping_power = 0.0_wp
      system%outside = .false.
      call add_contacts(system, friction_power, damping_power)
      call add_springs(system, damping_power)
      do i = 1, system%constraints%n_links
         associate (link => system%constraints%links(i))
            do j = 1, 2
               if (link%body(j) == 0) cycle
               call link%load_on(j, on_body, about_body)
               associate (load => system%load(link%body(j)))
                  load%force = load%force + on_body
                  load%torque = load%torque + about_body
               end associate
            end do
         end associate
      end do
      force = 0.0_wp
      torque = 0.0_wp
      do i = 1, size(system%bodies)
         if (system%bodies(i)%motion == motion_prescribed) force(:, i) = -system%load(i)%force
         if (turns_by_drive(system%bodies(i)%motion)) torque(:, i) = -system%load(i)%torque
         if (system%bodies(i)%motion == motion_rotor) torque(:, i) = about_axis(i)
      end do

   contains

      !> What keeps a rotor turning: the torque about its axis.
      pure function about_axis(body) result(drive)
         integer, intent(in) :: body
         real(wp) :: drive(3)
         real(wp) :: applied

         associate (axis => system%pose(body)%rotation(:, 3), own => system%bodies(body))
            applied = dot_product(own%torque, axis)
            if (own%load_follows) applied = own%torque(3)
            drive = -(dot_product(system%load(body)%torque, axis) + applied)*axis
         end associate
      end function about_axis

   end subroutine drive_loads

   !> Kinetic energy, and potential energy of gravity relative to the origin, of the free bodies
   !> and of the translation and tilting of those that only turn by a drive [J].
   pure subroutine energies(mechanism, y, kinetic, potential)
      class(mechanism_type), intent(in) :: mechanism
      real(wp), intent(in) :: y(:)
      !> Kinetic energy [J].
      real(wp), intent(out) :: kinetic
      !> Potential energy [J].
      real(wp), intent(out) :: potential
      real(wp) :: v(3), w(3)
      integer :: i

      kinetic = 0.0_wp
      potential = 0.0_wp
      do i = 1, size(mechanism%bodies)
         associate (body => mechanism%bodies(i))
            if (.not. moves_freely(body%motion)) cycle
            v = velocity_of(y, i)
            w = spin_of(y, i)
            kinetic = kinetic + 0.5_wp*body%mass*dot_product(v, v)
            if (body%motion == motion_free) kinetic = kinetic &
               + 0.5_wp*dot_product(body%inertia*w, w)
            if (body%motion == motion_rotor) kinetic = kinetic &
               + 0.5_wp*dot_product(body%inertia(:2)*w(:2), w(:2))
            potential = potential - body%mass*dot_product(mechanism%gravity, position_of(y, i))
         end associate
      end do
   end subroutine energies

   !> Linear momentum [kg m/s] and angular momentum about the origin [kg m2/s].
   pure subroutine momenta(mechanism, y, linear, angular)
      class(mechanism_type), intent(in) :: mechanism
      real(wp), intent(in) :: y(:)
      !> Linear momentum [kg m/s].
      real(wp), intent(out) :: linear(3)
      !> Angular momentum about the origin [kg m2/s].
      real(wp), intent(out) :: angular(3)
      integer :: i

      linear = 0.0_wp
      angular = 0.0_wp
      do i = 1, size(mechanism%bodies)
         associate (body => mechanism%bodies(i))
            linear = linear + body%mass*velocity_of(y, i)
            angular = angular + body%mass*cross(position_of(y, i), velocity_of(y, i)) &
               + matmul(rotation_matrix(quaternion_of(y, i)), body%inertia*spin_of(y, i))
         end associate
      end do
   end subroutine momenta

end module contensou_dynamics_reports
