!> `contensou bearing`: what an engineer reads of the run of a ball bearing.
module contensou_drivers_bearing
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : pi, wp
   use contensou_base_numbers, only : fixed_text, number_text, to_text
   use contensou_base_operating_system, only : write_stdout
   use contensou_base_text, only : right, text_buffer_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      takes_non_negative, takes_positive
   use contensou_files_bearing_run, only : bearing_run_type, read_bearings, run_losses_type
   use contensou_study_race_losses, only : race_spot_type, reference_life
   implicit none(type, external)
   private

   public :: bearing_command

   type(option_type), parameter :: options(*) = [ &
      option_type("FILE.h5", "", "output file of a run", needs="a file"), &
      option_type("--part", "P", "part of the run that counts, its end; default 0.5", &
      needs="a number above 0, at most 1", takes=takes_positive), &
      option_type("--rating", "C", "basic dynamic load rating [N], for the life", &
      needs="a load [N]", takes=takes_positive), &
      option_type("--nominal-angle", "A", "nominal contact angle of that rating [degrees]; " // &
      "contact_angle of &bearing if not given, or 0", needs="an angle [degrees]", &
      takes=takes_non_negative)]

   character(len=*), parameter :: nl = new_line("a")

   !> What is lost where.
   character(len=*), parameter :: causes(3) = [character(len=9) :: "pivoting", "sliding", &
      "curvature"], rings(2) = ["inner", "outer"]

   !> Ring speed below which there is no friction moment to tell [rad/s].
   real(wp), parameter :: still = 1.0e-9_wp

contains

   !> `contensou bearing` in the table of commands.
   function bearing_command() result(command)
      type(command_type) :: command

      command = command_type("bearing", "loads, angles, friction and life of ball bearings", &
         options, "prints for each ball bearing of a run loads, contact angles, stress and " // &
         "the ratio of spin to roll by ball, the speed of the cage, the friction moment by " // &
         "cause, beside quasi-static estimates, and with --rating the basic reference life", &
         "contensou bearing bearing_6205.h5 --rating 14800" // nl // &
         "contensou-plot bearing_6205.h5 --loads", execute=report_bearings)
   end function bearing_command

   !> Read the file and print.
   subroutine report_bearings(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when the file cannot be read or has no bearing.
      type(error_type), allocatable, intent(out) :: error
      type(bearing_run_type), allocatable :: bearings(:)
      type(run_losses_type) :: losses
      type(text_buffer_type) :: buffer
      real(wp) :: part, rating, nominal
      integer :: i

      part = line%number("--part", 0.5_wp)
      rating = line%number("--rating", 0.0_wp)
      if (part > 1.0_wp) then
         call fatal(error, "--part needs a number above 0, at most 1, not " // &
            to_text(part), status_usage)
         return
      end if
      nominal = line%number("--nominal-angle", 0.0_wp)
      if (nominal >= 90.0_wp) then
         call fatal(error, "--nominal-angle needs an angle from 0 to below 90 [degrees], not " // &
            to_text(nominal), status_usage)
         return
      end if
      call read_bearings(line%text("FILE.h5"), part, bearings, losses, error)
      if (allocated(error)) return
      do i = 1, size(bearings)
         associate (bearing => bearings(i))
            if (i > 1) call buffer%add(nl)
            call buffer%add("bearing " // bearing%name // ": " // to_text(bearing%balls) // &
               " balls, means from " // to_text(losses%from) // " s to " // &
               to_text(losses%until) // " s" // nl)
            call add_balls(bearing, buffer)
            call add_speeds(bearing, buffer)
            call add_moments(bearing, size(bearings) == 1, losses, buffer)
            call add_estimates(bearing, buffer)
            nominal = line%number("--nominal-angle", bearing%nominal*180.0_wp/pi)*pi/180.0_wp
            if (rating > 0.0_wp) call add_life(bearing, rating, nominal, buffer)
         end associate
      end do
      call write_stdout(buffer%text(), error)
   end subroutine report_bearings

   !> Loads, angles, stress and pivoting by ball.
   subroutine add_balls(bearing, buffer)
      type(bearing_run_type), intent(in) :: bearing
      type(text_buffer_type), intent(inout) :: buffer
      character(len=*), parameter :: arcs(2) = [" upper", " lower"]
      character(len=:), allocatable :: cells(:)
      integer :: b, a, k

      call buffer%add("ball             load [N]      angle [deg]     stress [MPa]        " // &
         "spin/roll" // nl // "            inner    outer   inner   outer    inner    outer" // &
         "    inner    outer" // nl)
      allocate(character(len=8) :: cells(8))
      do b = 1, bearing%balls
         do a = 1, bearing%arcs
            do k = 1, 2
               associate (race => bearing%races(k))
                  cells(k) = fixed_text(race%load(b, a), 1)
                  cells(2 + k) = "-"
                  cells(4 + k) = "-"
                  cells(6 + k) = "-"
                  if (.not. race%load(b, a) > 0.0_wp) cycle
                  cells(2 + k) = fixed_text(race%angle(b, a)*180.0_wp/pi, 2)
                  cells(4 + k) = fixed_text(1.0e-6_wp*race%stress(b, a), 0)
                  cells(6 + k) = fixed_text(race%pivoting(b, a), 4)
               end associate
            end do
            call buffer%add(right(to_text(b), 4))
            if (bearing%arcs == 2) then
               call buffer%add(arcs(a))
            else
               call buffer%add(repeat(" ", len(arcs)))
            end if
            call buffer%add(right(trim(cells(1)), 7) // right(trim(cells(2)), 9) // &
               right(trim(cells(3)), 8) // right(trim(cells(4)), 8))
            do k = 5, 8
               call buffer%add(right(trim(cells(k)), 9))
            end do
            call buffer%add(nl)
         end do
      end do
   end subroutine add_balls

   !> Speeds of the rings, the balls and the cage [rad/s].
   subroutine add_speeds(bearing, buffer)
      type(bearing_run_type), intent(in) :: bearing
      type(text_buffer_type), intent(inout) :: buffer

      call buffer%add("speed [rad/s]: inner ring " // number_text(bearing%races(1)%speed, 6) // &
         ", outer ring " // number_text(bearing%races(2)%speed, 6) // ", balls around the axis " &
         // number_text(bearing%orbit, 6))
      if (bearing%has_cage) call buffer%add(", cage " // number_text(bearing%cage, 6))
      call buffer%add(", epicyclic " // number_text(bearing%epicyclic(), 6) // nl)
   end subroutine add_speeds

   !> Speed of one ring against the other [rad/s].
   pure real(wp) function speed_of(bearing)
      type(bearing_run_type), intent(in) :: bearing

      speed_of = abs(bearing%races(1)%speed - bearing%races(2)%speed)
   end function speed_of

   !> Friction moment by cause.
   subroutine add_moments(bearing, alone, losses, buffer)
      type(bearing_run_type), intent(in) :: bearing
      !> Whether it is the only one of its scene.
      logical, intent(in) :: alone
      type(run_losses_type), intent(in) :: losses
      type(text_buffer_type), intent(inout) :: buffer
      real(wp) :: whole, rest
      integer :: c, k

      if (.not. speed_of(bearing) > still) return
      call buffer%add("friction moment by cause [N mm]" // nl)
      whole = 0.0_wp
      do c = 1, size(causes)
         do k = 1, 2
            call add_moment(trim(causes(c)) // ", " // rings(k) // " race", &
               bearing%races(k)%loss(c))
         end do
      end do
      if (bearing%has_cage) call add_moment("pockets of the cage", bearing%cage_loss)
      if (alone .and. losses%contacts == losses%of_bearings) then
         ! Works are of the whole scene.
         rest = losses%friction - whole
         call add_moment("rolling resistance, rest of the balance", rest)
         if (.not. losses%dashpots) call add_moment("damping", losses%damping)
      end if
      call buffer%add(row("whole", whole))

   contains

      !> Add a row of a power [W].
      subroutine add_moment(cause, loss)
         character(len=*), intent(in) :: cause
         real(wp), intent(in) :: loss

         whole = whole + loss
         call buffer%add(row(cause, loss))
      end subroutine add_moment

      !> A cause of friction by the moment that its loss [W] is at this speed.
      function row(cause, loss) result(text)
         character(len=*), intent(in) :: cause
         real(wp), intent(in) :: loss
         character(len=:), allocatable :: text

         text = moment_row(cause, loss/speed_of(bearing))
      end function row

   end subroutine add_moments

   !> A row of a friction moment [N m].
   function moment_row(cause, moment) result(text)
      character(len=*), intent(in) :: cause
      real(wp), intent(in) :: moment
      character(len=:), allocatable :: text

      text = "  " // cause // right(fixed_text(1.0e3_wp*moment, 4), 50 - len(cause)) // nl
   end function moment_row

   !> Quasi-static estimates of the friction moment with curved spots.
   subroutine add_estimates(bearing, buffer)
      type(bearing_run_type), intent(in) :: bearing
      type(text_buffer_type), intent(inout) :: buffer
      character(len=*), parameter :: ways(4) = [character(len=36) :: "no pivoting", &
         "all pivoting on the inner race", "all pivoting on the outer race", &
         "pivoting shared where least is lost"]
      type(race_spot_type) :: spots(2)
      real(wp) :: sums(4), spin, loss, torque
      integer :: b, k, m

      if (.not. speed_of(bearing) > still .or. bearing%arcs > 1) return
      sums = 0.0_wp
      do b = 1, bearing%balls
         spots = [(bearing%spot(k, b), k=1, 2)]
         if (.not. all(spots%load > 0.0_wp .and. spots%friction > 0.0_wp)) cycle
         spin = abs(bearing%races(1)%spin(b, 1) + bearing%races(2)%spin(b, 1))
         do k = 1, 2
            call spots(k)%power(0.0_wp, loss, torque)
            sums(1) = sums(1) + loss
            sums(4 - k) = sums(4 - k) + loss
            call spots(k)%power(spin, loss, torque)
            sums(1 + k) = sums(1 + k) + loss
         end do
         sums(4) = sums(4) + spots(1)%least_power(spots(2), spin)
      end do
      if (.not. any(sums > 0.0_wp)) return
      call buffer%add("quasi-static estimates of it with curved spots [N mm]" // nl)
      do m = 1, size(ways)
         call buffer%add(moment_row(trim(ways(m)), sums(m)/speed_of(bearing)))
      end do
   end subroutine add_estimates

   !> Basic reference life.
   subroutine add_life(bearing, rating, nominal, buffer)
      type(bearing_run_type), intent(in) :: bearing
      !> Basic dynamic load rating [N].
      real(wp), intent(in) :: rating
      !> Nominal contact angle [rad].
      real(wp), intent(in) :: nominal
      type(text_buffer_type), intent(inout) :: buffer
      real(wp) :: loads(bearing%balls, 2), life
      integer :: k

      do k = 1, 2
         loads(:, k) = sum(bearing%races(k)%load, dim=2)
      end do
      life = reference_life(loads, abs(bearing%races%speed) > still, rating, &
         bearing%radius/bearing%pitch, nominal, 0.5_wp*bearing%races%groove/bearing%radius)
      call buffer%add("basic reference life (ISO/TS 16281), nominal contact angle " // &
         number_text(nominal*180.0_wp/pi, 4) // " deg: " // number_text(life, 4) // &
         " million revolutions")
      if (speed_of(bearing) > still) call buffer%add(", " // number_text( &
         life*1.0e6_wp*2.0_wp*pi/(speed_of(bearing)*3600.0_wp), 4) // " h")
      call buffer%add(nl)
   end subroutine add_life

end module contensou_drivers_bearing
