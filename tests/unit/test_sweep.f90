!> Tests of the definition of sweeps: samplings, keys, cases and their scenes, the table.
module test_sweep
   use, intrinsic :: ieee_arithmetic, only : ieee_quiet_nan, ieee_value
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : i8, wp
   use contensou_base_numbers, only : to_text
   use contensou_base_schema, only : group_spec_type, key_type, kind_choice
   use contensou_base_text, only : string_type
   use contensou_scene_reader, only : read_scene, scene_file_type
   use contensou_study_summary, only : summary_quantities
   use contensou_sweep_plan, only : sweep_type
   use contensou_sweep_reader, only : read_sweep
   use contensou_sweep_sampling, only : permuted, sampler_type, sampling_latin, sampling_sobol, &
      uniform
   use contensou_base_resolve, only : expected_of
   use contensou_sweep_schema, only : sweep_groups, sweep_keys
   use contensou_sweep_table, only : case_complete, case_failed, read_table_header, &
      sweep_table_type, table_header_type, table_reader_type
   use test_harness, only : check, check_close
   implicit none(type, external)
   private

   public :: run_sweep_tests

   !> Line end.
   character(len=1), parameter :: lf = achar(10)

   !> A scene with a contact, a body that is turned, and no integrator.
   character(len=*), parameter :: scene_text = &
      "&scene t_end = 1, gravity = 0, 0, -9.81 /" // lf // &
      "&material name = 'steel', young = 2e11, poisson = 0.3 /" // lf // &
      "&body name = 'ball', mass = 1, inertia = 3*1e-2, position = 0, 0, 0.2, axis = 0, 1, 0," // &
      " angle = 0.1 /" // lf // &
      "&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.1," // &
      " material = 'steel' /" // lf // &
      "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /" // lf // &
      "&contact name = 'touch', surfaces = 'skin', 'floor', friction = 'coulomb'," // &
      " friction_coefficient = 0.2, regularization_velocity = 1e-3 /" // lf

   !> A sweep over it, with parameters of all kinds.
   character(len=*), parameter :: sweep_text = &
      "&sweep scene = 'base.nml' /" // lf // &
      "&parameter name = 'touch.friction', values = 'coulomb', 'pade11', 'contensou_exact' /" // &
      lf // &
      "&parameter name = 'ball.position(3)', first = 0.2, last = 0.7, count = 6," // &
      " column = 'height' /" // lf // &
      "&parameter name = 'integrator.rtol', vary = 'log', first = 1e-9, last = 1e-3, count = 4 /" &
      // lf // &
      "&parameter name = 'ball.velocity(2)', 'ball.velocity(1)', values = 1, -2.5 /" // lf // &
      "&parameter name = 'touch.drilling', values = .false., .true. /" // lf

contains

   !> Run all tests.
   subroutine run_sweep_tests(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder

      call test_keys()
      call test_permutation()
      call test_uniform()
      call test_latin_hypercube()
      call test_sobol()
      call write_file(folder // "/base.nml", scene_text)
      call test_tied(folder)
      call test_grid(folder)
      call test_scenes(folder)
      call test_fingerprint(folder)
      call test_table(folder)
   end subroutine run_sweep_tests

   !> Groups and keys are documented, and defaults are values.
   subroutine test_keys()
      type(group_spec_type), allocatable :: groups(:)
      type(key_type), allocatable :: keys(:)
      type(string_type), allocatable :: names(:)
      integer :: i, k
      logical :: found

      groups = sweep_groups()
      keys = sweep_keys()
      do i = 1, size(keys)
         associate (name => trim(keys(i)%group) // "." // trim(keys(i)%name))
            call check(any(groups%name == keys(i)%group), "sweep key " // name // ": has a group")
            call check(len_trim(keys(i)%doc) > 10 .and. len_trim(keys(i)%doc) < len(keys(i)%doc), &
               "sweep key " // name // ": documented, and not cut")
            call check(expected_of(keys(i)) /= "", "sweep key " // name // ": has a domain")
            call check(count(keys%group == keys(i)%group .and. keys%name == keys(i)%name) == 1, &
               "sweep key " // name // ": once")
            if (keys(i)%kind /= kind_choice) cycle
            names = keys(i)%names()
            call check(size(names) > 1, "sweep key " // name // ": has choices")
            if (keys(i)%default == "") cycle
            found = .false.
            do k = 1, size(names)
               found = found .or. "'" // names(k)%s // "'" == keys(i)%default
            end do
            call check(found, "sweep key " // name // ": its default is a choice")
         end associate
      end do
      call check(.not. any(summary_quantities%name == "cpu_s"), "CPU time is no result")
   end subroutine test_keys

   !> Permutations hit each number once, whatever their length.
   subroutine test_permutation()
      integer(i8), parameter :: lengths(*) = [integer(i8) :: 1, 2, 3, 10, 97, 255, 256, 257, 5000]
      logical, allocatable :: hit(:)
      integer(i8) :: i, j, moved, same
      integer :: k

      do k = 1, size(lengths)
         allocate(hit(0:lengths(k) - 1), source=.false.)
         moved = 0
         same = 0
         do i = 0, lengths(k) - 1
            j = permuted(i, lengths(k), 7_i8, 1)
            if (j >= 0 .and. j < lengths(k)) hit(j) = .true.
            if (j /= i) moved = moved + 1
            if (permuted(i, lengths(k), 7_i8, 2) == j) same = same + 1
         end do
         call check(all(hit), "permutation of " // to_text(lengths(k)) // ": each number once")
         if (lengths(k) > 50) call check(moved > lengths(k)*9/10, "permutation of " // &
            to_text(lengths(k)) // ": moves most")
         if (lengths(k) > 50) call check(same < lengths(k)/10, "permutation of " // &
            to_text(lengths(k)) // ": another key, another permutation")
         deallocate(hit)
      end do
      j = permuted(123456789012_i8, 2_i8**40, 3_i8, 1)
      call check(j >= 0 .and. j < 2_i8**40, "permutation of the largest length")
   end subroutine test_permutation

   !> Numbers that look random: moments, and no equal ones.
   subroutine test_uniform()
      integer, parameter :: n = 20000
      real(wp) :: x(n), y(n)
      integer :: i

      do i = 1, n
         x(i) = uniform(5_i8, 1, int(i, i8))
         y(i) = uniform(5_i8, 2, int(i, i8))
      end do
      call check(all(x >= 0.0_wp .and. x < 1.0_wp), "uniform: in [0, 1)")
      ! Five standard deviations each.
      call check_close(sum(x)/n, 0.5_wp, 5.0_wp*sqrt(1.0_wp/12.0_wp/n), "uniform: mean")
      call check_close(sum((x - 0.5_wp)**2)/n, 1.0_wp/12.0_wp, 5.0_wp*sqrt(1.0_wp/180.0_wp/n), &
         "uniform: variance")
      call check_close(sum((x - 0.5_wp)*(y - 0.5_wp))/n, 0.0_wp, 5.0_wp/12.0_wp/sqrt(real(n, wp)), &
         "uniform: sequences do not correlate")
      call check_close(sum((x(:n - 1) - 0.5_wp)*(x(2:) - 0.5_wp))/n, 0.0_wp, &
         5.0_wp/12.0_wp/sqrt(real(n, wp)), "uniform: neighbours do not correlate")
      call check(abs(uniform(5_i8, 1, 1_i8) - uniform(6_i8, 1, 1_i8)) > 0.0_wp, &
         "uniform: another seed, another number")
      call check(abs(uniform(5_i8, 1, 1_i8) - uniform(5_i8 + 2_i8**33, 1, 1_i8)) > 0.0_wp, &
         "uniform: all bits of a seed count")
   end subroutine test_uniform

   !> Each stratum of each dimension has one point.
   subroutine test_latin_hypercube()
      type(sampler_type) :: sampler
      integer, parameter :: n = 321, dimensions = 5
      logical :: hit(0:n - 1, dimensions)
      integer :: d, i, stratum

      sampler%sampling = sampling_latin
      sampler%n = n
      sampler%seed = 11
      call sampler%begin(dimensions, .true.)
      hit = .false.
      do d = 1, dimensions
         do i = 1, n
            stratum = int(sampler%coordinate(int(i, i8), d)*n)
            if (stratum >= 0 .and. stratum < n) hit(stratum, d) = .true.
         end do
      end do
      call check(all(hit), "Latin hypercube: one point in each stratum")
   end subroutine test_latin_hypercube

   !> The first points are those of the library, and a shift moves all points alike.
   subroutine test_sobol()
      ! Points 1 to 6 of gsl_qrng_sobol in two dimensions.
      real(wp), parameter :: known(2, 6) = reshape([0.5_wp, 0.5_wp, 0.75_wp, 0.25_wp, 0.25_wp, &
         0.75_wp, 0.375_wp, 0.375_wp, 0.875_wp, 0.875_wp, 0.625_wp, 0.125_wp], [2, 6])
      type(sampler_type) :: plain, shifted
      integer, parameter :: k = 9, dimensions = 40
      logical :: hit(0:2**k - 1, dimensions), alike
      real(wp) :: shift, step
      integer :: d, i, cell

      plain%sampling = sampling_sobol
      plain%n = 2**k - 1
      plain%seed = 4
      shifted = plain
      call plain%begin(dimensions, .false.)
      call shifted%begin(dimensions, .true.)
      alike = .true.
      do i = 1, size(known, 2)
         do d = 1, 2
            call check_close(plain%coordinate(int(i, i8), d), known(d, i), 0.0_wp, &
               "Sobol: point " // to_text(i) // ", dimension " // to_text(d))
         end do
      end do
      hit = .false.
      do d = 1, dimensions
         shift = shifted%shift(d)
         do i = 1, 2**k - 1
            cell = int(plain%coordinate(int(i, i8), d)*2**k)
            if (cell >= 0 .and. cell < 2**k) hit(cell, d) = .true.
            step = shifted%coordinate(int(i, i8), d) - plain%coordinate(int(i, i8), d) - shift
            if (abs(step - anint(step)) > 1.0e-15_wp) alike = .false.
         end do
      end do
      call check(all(hit(1:, :)) .and. .not. any(hit(0, :)), &
         "Sobol: 2^k - 1 points in all intervals of 2^-k but the first")
      call check(alike, "Sobol: one shift for all points")
   end subroutine test_sobol

   !> Tied paths must be of one kind and unit; a mistake is reported at its place.
   subroutine test_tied(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder
      type(sweep_type) :: sweep
      type(error_type), allocatable :: error

      call write_file(folder // "/sweep.nml", "&sweep scene = 'base.nml' /" // lf // &
         "&parameter name = 'ball.mass', 'ball.angle', first = 1, last = 2, count = 2 /" // lf)
      call read_sweep(folder // "/sweep.nml", [string_type ::], "", sweep, error)
      call check(allocated(error), "paths with other units cannot be tied")
      if (allocated(error)) call check(index(error%message, "sweep.nml:2:32: error") > 0, &
         "a path that cannot be tied is shown")
      call write_file(folder // "/sweep.nml", "&sweep scene = 'base.nml' /" // lf // &
         "&parameter name = 'ball.mass', 'touch.friction', values = 1, 2 /" // lf)
      call read_sweep(folder // "/sweep.nml", [string_type ::], "", sweep, error)
      call check(allocated(error), "a number and a text cannot be tied")
   end subroutine test_tied

   !> The last parameter varies fastest, ends are exact, logarithmic steps are equal.
   subroutine test_grid(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder
      type(sweep_type) :: sweep
      type(error_type), allocatable :: error
      type(string_type) :: words(5)
      real(wp) :: values(5), heights(6), tolerances(4)
      integer(i8) :: i
      integer :: k

      call write_file(folder // "/sweep.nml", sweep_text)
      call read_sweep(folder // "/sweep.nml", [string_type ::], "", sweep, error)
      call check(.not. allocated(error), "grid: is read")
      if (allocated(error)) return
      call check(sweep%n_cases == 3*6*4*2*2, "grid: number of cases")
      call check(sweep%output == "sweep.h5", "grid: name of the table")
      call sweep%parameters_of(1_i8, values, words)
      call check(words(1)%s == "coulomb" .and. words(5)%s == ".false.", "grid: words of case 1")
      call check_close(values(2), 0.2_wp, 0.0_wp, "grid: first end")
      call sweep%parameters_of(2_i8, values, words)
      call check(words(5)%s == ".true.", "grid: the last parameter varies fastest")
      call sweep%parameters_of(3_i8, values, words)
      call check(words(5)%s == ".false.", "grid: and comes again")
      call check_close(values(4), -2.5_wp, 0.0_wp, "grid: the one before varies then")
      call sweep%parameters_of(sweep%n_cases, values, words)
      call check(words(1)%s == "contensou_exact", "grid: words of the last case")
      call check_close(values(2), 0.7_wp, 0.0_wp, "grid: last end, linear")
      call check_close(values(3), 1.0e-3_wp, 0.0_wp, "grid: last end, logarithmic")
      do k = 1, 6
         i = 16*(k - 1) + 1
         call sweep%parameters_of(i, values, words)
         heights(k) = values(2)
      end do
      do k = 1, 4
         i = 4*(k - 1) + 1
         call sweep%parameters_of(i, values, words)
         tolerances(k) = values(3)
      end do
      call check(all(abs(heights(2:) - heights(:5) - 0.1_wp) < 1.0e-15_wp), "grid: linear steps")
      call check(all(abs(tolerances(2:)/tolerances(:3) - 100.0_wp) < 1.0e-11_wp), &
         "grid: logarithmic steps")
   end subroutine test_grid

   !> The scene of a case is the one that a run with the same settings has.
   subroutine test_scenes(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder
      type(string_type) :: setting(1)
      type(sweep_type) :: sweep
      type(error_type), allocatable :: error, other_error
      type(scene_file_type) :: file, other
      type(string_type), allocatable :: overrides(:)
      integer(i8) :: i
      logical :: same

      call write_file(folder // "/sweep.nml", sweep_text // &
         "&parameter name = 'touch.restitution', values = 0.5 /" // lf)
      call read_sweep(folder // "/sweep.nml", [string_type ::], "", sweep, error)
      call check(.not. allocated(error), "scenes: the sweep is read")
      if (allocated(error)) return
      call sweep%scene_of(1_i8, file, error)
      call check(allocated(error), "scenes: restitution without damping is no scene")
      if (allocated(error)) call check(index(error%message, "'restitution' without 'damping'") == &
         1 .and. index(error%message, lf) == 0, "scenes: it is said in one line")

      call write_file(folder // "/sweep.nml", sweep_text)
      ! A structure constructor would leak its text.
      setting(1)%s = "scene.t_end = 3"
      call read_sweep(folder // "/sweep.nml", setting, "", sweep, error)
      call check(.not. allocated(error), "scenes: the sweep is read with a setting")
      if (allocated(error)) return
      same = .true.
      do i = 1, sweep%n_cases
         call sweep%overrides_of(i, overrides)
         call read_scene(folder // "/base.nml", overrides, "", other, other_error)
         call sweep%scene_of(i, file, error)
         if (allocated(error) .or. allocated(other_error)) then
            same = .false.
            exit
         end if
         associate (a => file%scene, b => other%scene)
            same = same .and. a%contacts(1)%friction == b%contacts(1)%friction
            same = same .and. (a%contacts(1)%parameters%flag("drilling") .eqv. &
               b%contacts(1)%parameters%flag("drilling"))
            same = same .and. a%integrator%method == b%integrator%method
            same = same .and. all(equal([a%bodies(1)%position, a%bodies(1)%quaternion, &
               a%bodies(1)%spin, a%bodies(1)%velocity, a%t_end, a%integrator%rtol, &
               a%integrator%length_scale, a%output%interval, &
               a%contacts(1)%parameters%number("friction_coefficient")], &
               [b%bodies(1)%position, b%bodies(1)%quaternion, b%bodies(1)%spin, &
               b%bodies(1)%velocity, b%t_end, b%integrator%rtol, b%integrator%length_scale, &
               b%output%interval, &
               b%contacts(1)%parameters%number("friction_coefficient")]))
         end associate
      end do
      call check(same, "scenes: those of runs with the same settings")
      call check_close(file%scene%bodies(1)%position(3), 0.7_wp, 0.0_wp, &
         "scenes: the last case has the last value")
      call check(all(equal(file%scene%bodies(1)%velocity(:2), [-2.5_wp, -2.5_wp])), &
         "scenes: tied paths have the same value")
      call check_close(file%scene%t_end, 3.0_wp, 0.0_wp, "scenes: settings for all cases hold")
   end subroutine test_scenes

   !> Whether numbers have the same bits.
   elemental function equal(a, b)
      !> A number.
      real(wp), intent(in) :: a
      !> Another number.
      real(wp), intent(in) :: b
      logical :: equal

      equal = transfer(a, 0_i8) == transfer(b, 0_i8)
   end function equal

   !> A fingerprint tells what changes rows, and only that.
   subroutine test_fingerprint(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder
      character(len=16) :: plain

      plain = fingerprint("")
      call check(fingerprint("sweep.output='other.h5'") == plain, "fingerprint: not of the output")
      call check(fingerprint("sweep.trajectories=3,4") == plain, &
         "fingerprint: not of the trajectories")
      call check(fingerprint("scene.t_end=2") /= plain, "fingerprint: of settings")
      call check(fingerprint("sweep.keep=summary") /= plain, "fingerprint: of results")
      call check(fingerprint("sweep.time_limit=3") /= plain, "fingerprint: of the time limit")
      call check(fingerprint("sweep.sampling=latin_hypercube") /= plain, &
         "fingerprint: of the sampling")

   contains

      !> Fingerprint of the sweep with a setting.
      function fingerprint(setting) result(text)
         !> The setting; empty for none.
         character(len=*), intent(in) :: setting
         character(len=16) :: text
         type(sweep_type) :: sweep
         type(error_type), allocatable :: error
         character(len=:), allocatable :: file
         type(string_type) :: settings(2)

         file = "&sweep scene = 'base.nml' /" // lf // &
            "&parameter name = 'ball.mass', values = 1, 2, 3, 4 /" // lf
         if (setting == "sweep.sampling=latin_hypercube") file = &
            "&sweep scene = 'base.nml', cases = 4 /" // lf // &
            "&parameter name = 'ball.mass', values = 1, 2, 3, 4 /" // lf
         call write_file(folder // "/sweep.nml", file)
         settings(1)%s = setting
         settings(2)%s = "ball.mass=1.5"
         if (setting == "") then
            call read_sweep(folder // "/sweep.nml", settings(:0), "", sweep, error)
         else
            call read_sweep(folder // "/sweep.nml", settings(:1), "", sweep, error)
         end if
         call check(.not. allocated(error), "fingerprint: " // setting // " is read")
         text = sweep%fingerprint
      end function fingerprint

   end subroutine test_fingerprint

   !> What is written is read back, over the ends of chunks, and joined.
   subroutine test_table(folder)
      !> Folder for files.
      character(len=*), intent(in) :: folder
      integer, parameter :: n = 20000, most = 3000
      type(sweep_type) :: sweep
      type(sweep_table_type) :: table
      type(table_reader_type) :: reader, joined
      type(table_header_type) :: header
      type(error_type), allocatable :: error
      type(string_type) :: messages(most)
      integer(i8) :: cases(most), back(n)
      integer :: status(most), i, first, last
      real(wp), allocatable :: results(:, :)

      call write_file(folder // "/sweep.nml", &
         "&sweep scene = 'base.nml', keep = 'steps', 'time' /" // lf // &
         "&parameter name = 'ball.mass', first = 1, last = 2, count = 20000 /" // lf)
      call read_sweep(folder // "/sweep.nml", [string_type ::], "", sweep, error)
      call check(.not. allocated(error), "table: the sweep is read")
      if (allocated(error)) return
      allocate(results(size(sweep%results), most))
      call check(size(sweep%results) == 2, "table: two results")
      call table%open(folder // "/table.h5", .false., sweep, "1:20000", "test", error)
      call check(.not. allocated(error), "table: is created")
      if (allocated(error)) return
      first = 1
      do while (first <= n)
         last = min(first + most - 1, n)
         do i = first, last
            associate (k => i - first + 1)
               cases(k) = i
               status(k) = merge(case_failed, case_complete, mod(i, 7) == 0)
               messages(k)%s = ""
               results(:, k) = [real(i, wp)/3.0_wp, real(2*i, wp)]
               if (mod(i, 7) /= 0) cycle
               messages(k)%s = "case " // to_text(i)
               results(:, k) = ieee_value(1.0_wp, ieee_quiet_nan)
            end associate
         end do
         call table%append(sweep, cases(:last - first + 1), status, messages, results, error)
         if (allocated(error)) exit
         first = last + 1
      end do
      if (.not. allocated(error)) call table%finish(error)
      call check(.not. allocated(error), "table: is written")
      call check(table%counts(case_failed) == 2857, "table: counts what failed, one in seven")
      call read_table_header(folder // "/table.h5", header, error)
      call check(.not. allocated(error), "table: is read")
      if (allocated(error)) return
      call check(header%n_rows == n .and. header%n_cases == n .and. header%cases == "1:20000" &
         .and. header%fingerprint == sweep%fingerprint, "table: says what it is")

      call reader%open(folder // "/table.h5", error)
      call table%open_like(folder // "/joined.h5", .false., reader, "2:9000,9005:20000", "test", &
         error)
      call table%append_from(reader, 2_i8, 9000_i8, error)
      call table%append_from(reader, 9005_i8, 20000_i8, error)
      call table%finish(error)
      call check(.not. allocated(error), "table: pieces are joined")
      call joined%open(folder // "/joined.h5", error)
      call check(joined%header%n_rows == 19995, "table: rows of the pieces")
      call check(joined%difference(reader) == "", "table: the pieces belong together")
      call joined%numbers(1_i8, back(:19995), error)
      call check(back(1) == 2 .and. back(8999) == 9000 .and. back(9000) == 9005 .and. &
         back(19995) == 20000, "table: cases of the pieces")
      call joined%close()
      call reader%close()

      call table%open(folder // "/table.h5", .false., sweep, "1:20000", "test", error)
      call table%finish(error)
      call check(allocated(error), "table: replaces nothing unasked")
      call read_table_header(folder // "/base.nml", header, error)
      call check(allocated(error), "table: a scene is none")
   end subroutine test_table

   !> Write a text file.
   subroutine write_file(path, text)
      !> Name of the file.
      character(len=*), intent(in) :: path
      character(len=*), intent(in) :: text
      integer :: unit

      open(newunit=unit, file=path, access="stream", form="unformatted", status="replace", &
         action="write")
      write(unit) text
      close(unit)
   end subroutine write_file

end module test_sweep
