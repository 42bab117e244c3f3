!> What `contensou bench kernels` tells: the table and the bars as text, CSV and HDF5.
module contensou_drivers_bench_report
   use, intrinsic :: ieee_arithmetic, only : ieee_is_nan
   use contensou_base_build, only : build_compiler, build_flags
   use contensou_base_errors, only : error_type
   use contensou_base_kinds, only : wp
   use contensou_base_numbers, only : fixed_text, power_text, to_text
   use contensou_base_operating_system, only : host_name
   use contensou_base_text, only : right
   use contensou_drivers_bench_bars, only : bar_type, bars_of, met
   use contensou_drivers_bench_baselines, only : boost_version
   use contensou_drivers_bench_suite, only : kernel_creep, kernel_creep_jacobian, kernel_curved, &
      kernel_elliptic, kernel_hertz, kernel_jacobian, kernel_ke, kernel_log, kernel_names, &
      kernel_tangential, kernel_wrench, max_quantities, name_length, suite_type
   use contensou_files_hdf5_file, only : hdf5_file_type, hdf5_series_type, hdf5_version, series_real
   use contensou_files_provenance, only : put_header
   implicit none(type, external)
   private

   public :: table_text, bars_text, csv_text, write_hdf5, filetype, filetype_version

   !> What the file is, for programs that open it.
   character(len=*), parameter :: filetype = "contensou-bench"

   !> Version of the format: the second number grows with additions, the first with changes.
   character(len=*), parameter :: filetype_version = "1.0"

   character(len=*), parameter :: nl = new_line("a")

   !> Largest number of columns of errors in the table.
   integer, parameter :: max_groups = 3

   !> What is told about a kernel.
   type :: layout_type
      !> What it computes.
      character(len=60) :: title = ""
      character(len=name_length) :: quantities(max_quantities) = ""
      !> Number of them.
      integer :: n = 0
      !> Their columns in the table.
      integer :: groups(max_quantities) = 0
      !> Headings of the columns.
      character(len=name_length) :: headings(max_groups) = ""
      !> Units of the errors: ulp, or blank for absolute or relative ones.
      character(len=3) :: unit = ""
   end type layout_type

contains

   !> What is told about a kernel.
   pure function layout_of(kernel) result(layout)
      integer, intent(in) :: kernel
      type(layout_type) :: layout

      select case (kernel)
      case (kernel_elliptic)
         layout%title = "elliptic integrals, all six, by c1"
         layout%n = 6
         layout%quantities = [character(len=name_length) :: "K", "E", "B", "D", "dKdc", "dEdc"]
         layout%groups = [1, 1, 1, 1, 2, 2]
         layout%headings(:2) = [character(len=name_length) :: "K, E, B, D", "dK/dc, dE/dc"]
         layout%unit = "ulp"
      case (kernel_ke)
         layout%title = "elliptic integrals K and E alone, by c1"
         layout%n = 2
         layout%quantities(:2) = [character(len=name_length) :: "K", "E"]
         layout%groups(:2) = [1, 2]
         layout%headings(:2) = [character(len=name_length) :: "K", "E"]
         layout%unit = "ulp"
      case (kernel_hertz)
         layout%title = "Hertz contact: A, B, E*, d -> c1, a, b, N, p0"
         layout%n = 5
         layout%quantities(:5) = [character(len=name_length) :: "c1", "a", "b", "N", "p0"]
         layout%groups(:5) = [1, 2, 2, 1, 3]
         layout%headings = [character(len=name_length) :: "N, c1", "a, b", "p0"]
         layout%unit = "ulp"
      case (kernel_wrench)
         layout%title = "friction wrench: v_x, v_y, a w -> F, T in f N, f N a"
         layout%n = 3
         layout%quantities(:3) = [character(len=name_length) :: "F", "T", "T_relative"]
         layout%groups(:3) = [1, 1, 2]
         layout%headings(:2) = [character(len=name_length) :: "F, T", "T, relative"]
      case (kernel_jacobian)
         layout%title = "friction wrench with its Jacobian"
         layout%n = 4
         layout%quantities(:4) = [character(len=name_length) :: "F", "T", "T_relative", "J"]
         layout%groups(:4) = [1, 1, 2, 3]
         layout%headings = [character(len=name_length) :: "F, T", "T, relative", &
            "J over largest"]
      case (kernel_curved)
         layout%title = "friction of a curved spot: v_x, v_y, a w -> F, T"
         layout%n = 3
         layout%quantities(:3) = [character(len=name_length) :: "F", "T", "T_relative"]
         layout%groups(:3) = [1, 1, 2]
         layout%headings(:2) = [character(len=name_length) :: "F, T", "T, relative"]
      case (kernel_creep, kernel_creep_jacobian, kernel_tangential)
         layout%title = "laws of creep: v_x, v_y, a w -> F, T in f N, f N a"
         if (kernel == kernel_creep_jacobian) layout%title = "laws of creep with their Jacobian"
         if (kernel == kernel_tangential) layout%title = &
            "tangential elasticity: steps d_x, d_y, twist -> F, T"
         layout%n = 2
         layout%quantities(:2) = [character(len=name_length) :: "F", "T"]
         layout%groups(:2) = [1, 2]
         layout%headings(:2) = [character(len=name_length) :: "F", "T"]
      case default
         layout%title = ""
      end select
   end function layout_of

   !> Number of arguments that were compared, as the longest case has.
   pure function checked_text(suite, kernel) result(text)
      type(suite_type), intent(in) :: suite
      integer, intent(in) :: kernel
      character(len=:), allocatable :: text
      integer :: i

      text = ""
      do i = 1, size(suite%cases)
         if (suite%cases(i)%kernel == kernel) text = to_text(suite%cases(i)%checked)
      end do
   end function checked_text

   !> Times and errors of all rungs, in columns.
   function table_text(suite) result(text)
      type(suite_type), intent(in) :: suite
      character(len=:), allocatable :: text
      type(layout_type) :: layout
      real(wp) :: logarithm(2)
      integer :: i, kernel, group, last_case

      logarithm = suite%rungs(1)%seconds
      text = "one log() takes " // trim(adjustl(cell(1.0e9_wp*logarithm(1), 8))) // &
         " ns in throughput and " // trim(adjustl(cell(1.0e9_wp*logarithm(2), 8))) // &
         " ns in a chain" // nl
      do kernel = kernel_elliptic, kernel_tangential
         layout = layout_of(kernel)
         text = text // nl // trim(kernel_names(kernel)) // ": " // trim(layout%title) // nl
         if (layout%unit == "ulp") then
            text = text // "errors in ulp"
         else
            text = text // "errors absolute, relative where it says so"
         end if
         text = text // ", largest and median of " // checked_text(suite, kernel) // &
            " arguments a case" // nl
         text = text // repeat(" ", 24)
         do group = 1, maxval(layout%groups)
            text = text // right(trim(layout%headings(group)), 18)
         end do
         text = text // right("without", 9) // right("throughput", 16) // right("chain", 16) // nl
         text = text // repeat(" ", 24)
         do group = 1, maxval(layout%groups)
            text = text // right("max", 9) // right("median", 9)
         end do
         text = text // right("result", 9) // right("ns", 8) // right("/log", 8) // &
            right("ns", 8) // right("/log", 8) // nl
         last_case = 0
         do i = 1, size(suite%rungs)
            associate (rung => suite%rungs(i), c => suite%cases(suite%rungs(i)%place))
               if (c%kernel /= kernel) cycle
               if (rung%place /= last_case) text = text // " " // trim(c%title) // nl
               last_case = rung%place
               text = text // "   " // rung%name // " "
               do group = 1, maxval(layout%groups)
                  if (rung%is_reference) then
                     text = text // right("reference", 18)
                  else
                     text = text // cell(largest_of(rung%error_max, layout, group), 9) // &
                        cell(largest_of(rung%error_median, layout, group), 9)
                  end if
               end do
               text = text // right(percentage(rung%misses, c%checked), 9)
               text = text // cell(1.0e9_wp*rung%seconds(1), 8) // &
                  cell(rung%seconds(1)/logarithm(1), 8) // cell(1.0e9_wp*rung%seconds(2), 8) // &
                  cell(rung%seconds(2)/logarithm(2), 8) // nl
            end associate
         end do
      end do
   end function table_text

   !> Largest error of the quantities in a column; NaN if there are no results.
   pure real(wp) function largest_of(errors, layout, group)
      real(wp), intent(in) :: errors(max_quantities)
      !> What is told about the kernel.
      type(layout_type), intent(in) :: layout
      !> The column.
      integer, intent(in) :: group
      integer :: i

      largest_of = 0.0_wp
      do i = 1, layout%n
         if (layout%groups(i) /= group) cycle
         ! Comparing a NaN raises an exception.
         if (ieee_is_nan(errors(i))) then
            largest_of = errors(i)
            return
         end if
         largest_of = max(largest_of, errors(i))
      end do
   end function largest_of

   !> A share in words.
   pure function percentage(part, whole) result(text)
      integer, intent(in) :: part
      integer, intent(in) :: whole
      character(len=:), allocatable :: text

      text = "0"
      if (part > 0) text = to_text(max(1, nint(100.0_wp*part/whole))) // " %"
   end function percentage

   !> A number for the table, to two digits or three.
   pure function cell(x, width) result(text)
      real(wp), intent(in) :: x
      !> Width of the column.
      integer, intent(in) :: width
      character(len=width) :: text

      if (ieee_is_nan(x)) then
         text = right("-", width)
      else if (x >= 99.95_wp .and. x < 99999.5_wp) then
         text = right(to_text(nint(x)), width)
      else if (x >= 9.995_wp .and. x < 99.95_wp) then
         text = right(fixed_text(x, 1), width)
      else if ((x >= 0.095_wp .and. x < 9.995_wp) .or. x <= 0.0_wp) then
         text = right(fixed_text(x, 2), width)
      else
         text = right(power_text(x, 2), width)
      end if
   end function cell

   !> What rungs are held to, with what was measured.
   function bars_text(suite) result(text)
      type(suite_type), intent(in) :: suite
      character(len=:), allocatable :: text
      type(bar_type), allocatable :: bars(:)
      integer :: i

      bars = bars_of(suite)
      text = "what is to be achieved" // repeat(" ", 28) // "measured       bar" // nl
      do i = 1, size(bars)
         text = text // "  " // bars(i)%name(:46) // cell(bars(i)%measured, 10) // "  " // &
            merge(">=", "<=", bars(i)%at_least) // cell(bars(i)%limit, 8) // "  " // &
            trim(merge("met   ", "MISSED", met(bars(i)))) // nl
      end do
   end function bars_text

   !> All measurements as CSV, a row for each rung of each case and each quantity.
   function csv_text(suite) result(text)
      type(suite_type), intent(in) :: suite
      character(len=:), allocatable :: text
      type(layout_type) :: layout
      integer :: i, j

      text = "kernel,case,rung,quantity,error_unit,error_max,error_median,checked,misses," // &
         "ns,ns_chain,log_ratio,log_ratio_chain" // nl
      associate (logarithm => suite%rungs(1)%seconds)
         do i = 1, size(suite%rungs)
            associate (rung => suite%rungs(i), c => suite%cases(suite%rungs(i)%place))
               layout = layout_of(c%kernel)
               do j = 1, layout%n
                  text = text // trim(kernel_names(c%kernel)) // "," // trim(c%name) // "," // &
                     trim(rung%name) // "," // trim(layout%quantities(j)) // "," // &
                     trim(merge(layout%unit, "1  ", layout%unit /= "")) // "," // &
                     to_text(rung%error_max(j)) // "," // to_text(rung%error_median(j)) // "," // &
                     to_text(c%checked) // "," // to_text(rung%misses) // "," // &
                     to_text(1.0e9_wp*rung%seconds(1)) // "," // &
                     to_text(1.0e9_wp*rung%seconds(2)) // "," // &
                     to_text(rung%seconds(1)/logarithm(1)) // "," // &
                     to_text(rung%seconds(2)/logarithm(2)) // nl
               end do
            end associate
         end do
      end associate
   end function csv_text

   !> All measurements and bars as an HDF5 file, complete but still open.
   subroutine write_hdf5(suite, name, rounds, file, error)
      type(suite_type), intent(in) :: suite
      !> Name of the file while it is written.
      character(len=*), intent(in) :: name
      !> Number of rounds of the measurement.
      integer, intent(in) :: rounds
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      integer :: kernel

      call file%create(name, error)
      if (allocated(error)) return
      call put_header(file, filetype, filetype_version, "complete", error)
      call file%put_attribute("/", "NX_class", "NXroot", error)
      call file%put_attribute("/", "default", "elliptic", error)
      call file%create_group("/provenance", error)
      call file%put_text("/provenance/compiler", build_compiler, "compiler", error)
      call file%put_text("/provenance/flags", build_flags, "compiler flags", error)
      call file%put_text("/provenance/hdf5", hdf5_version(), "version of HDF5", error)
      call file%put_value("/provenance/boost", int(boost_version()), "", &
         "version of Boost, 107400 for 1.74; 0 for none", error)
      call file%put_text("/provenance/host", host_name(), "host", error)
      call file%create_group("/log", error)
      call file%put_value("/log/ns", 1.0e9_wp*suite%rungs(1)%seconds(1), "ns", &
         "time of log() in throughput", error)
      call file%put_value("/log/ns_chain", 1.0e9_wp*suite%rungs(1)%seconds(2), "ns", &
         "time of log() in a dependent chain", error)
      call file%put_value("/log/rounds", rounds, "1", "rounds of batches", error)
      do kernel = kernel_log + 1, kernel_tangential
         call put_kernel(suite, kernel, file, error)
      end do
      call put_bars(suite, file, error)
      ! A failure is kept by the file, so that this last call sees the first one.
      call file%flush(error)
   end subroutine write_hdf5

   !> What is known about a kernel.
   subroutine put_kernel(suite, kernel, file, error)
      type(suite_type), intent(in) :: suite
      integer, intent(in) :: kernel
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      type(layout_type) :: layout
      integer, allocatable :: places(:), rungs(:, :), counts(:)
      real(wp), allocatable :: values(:, :), errors(:, :, :)
      character(len=name_length), allocatable :: names(:)
      character(len=80), allocatable :: titles(:)
      character(len=:), allocatable :: group, about
      character(len=40) :: scales(3)
      real(wp) :: logarithm(2)
      integer :: i, j, n_cases, n_rungs

      layout = layout_of(kernel)
      logarithm = suite%rungs(1)%seconds
      places = pack([(i, i=1, size(suite%cases))], suite%cases%kernel == kernel)
      n_cases = size(places)
      ! The same rungs for each case, one case after the other.
      n_rungs = count(suite%rungs%place == places(1))
      allocate(rungs(n_rungs, n_cases), values(n_rungs, n_cases))
      allocate(errors(layout%n, n_rungs, n_cases))
      do j = 1, n_cases
         rungs(:, j) = pack([(i, i=1, size(suite%rungs))], suite%rungs%place == places(j))
      end do
      group = "/" // trim(kernel_names(kernel)) // "/"
      call file%create_group(group(:len(group) - 1), error)
      call file%put_attribute(group(:len(group) - 1), "title", trim(layout%title), error)
      call file%put_attribute(group(:len(group) - 1), "NX_class", "NXdata", error)
      call file%put_attribute(group(:len(group) - 1), "signal", "ns", error)
      call file%put_attribute_values(group(:len(group) - 1), "axes", ["case", "rung"], error)
      scales = [character(len=len(scales)) :: group // "case", group // "rung", &
         group // "quantity"]
      names = suite%cases(places)%name
      call file%put_labels(trim(scales(1)), names, "set of arguments", error)
      names = suite%rungs(rungs(:, 1))%name
      call file%put_labels(trim(scales(2)), names, "way to compute", error)
      names = layout%quantities(:layout%n)
      call file%put_labels(trim(scales(3)), names, "result", error)
      titles = suite%cases(places)%title
      call file%put_texts(group // "case_title", titles, scales(:1), &
         "what is in the set of arguments", error)
      counts = suite%cases(places)%checked
      call file%put_array(group // "checked", counts, scales(:1), "1", &
         "arguments that are compared with the reference", error)
      call table("misses", "1", "compared arguments without a result")
      call table("ns", "ns", "time of a call in throughput")
      call table("ns_chain", "ns", "time of a call in a dependent chain")
      call table("log_ratio", "1", "time in throughput over that of log()")
      call table("log_ratio_chain", "1", "time in a dependent chain over that of log()")
      about = ", in f N and f N a or relative"
      if (layout%unit == "ulp") about = ", in units in the last place"
      call cube("error_max", "largest error" // about)
      call cube("error_median", "median of the errors" // about)

   contains

      !> Write a table over cases and rungs.
      subroutine table(name, units, long_name)
         character(len=*), intent(in) :: name
         character(len=*), intent(in) :: units
         character(len=*), intent(in) :: long_name
         integer :: m, n

         do n = 1, n_cases
            do m = 1, n_rungs
               associate (rung => suite%rungs(rungs(m, n)))
                  select case (name)
                  case ("misses")
                     values(m, n) = real(rung%misses, wp)
                  case ("ns")
                     values(m, n) = 1.0e9_wp*rung%seconds(1)
                  case ("ns_chain")
                     values(m, n) = 1.0e9_wp*rung%seconds(2)
                  case ("log_ratio")
                     values(m, n) = rung%seconds(1)/logarithm(1)
                  case default
                     values(m, n) = rung%seconds(2)/logarithm(2)
                  end select
               end associate
            end do
         end do
         call file%put_array(group // name, values, scales(:2), units, long_name, error)
      end subroutine table

      !> Write errors over cases, rungs and quantities.
      subroutine cube(name, long_name)
         character(len=*), intent(in) :: name
         character(len=*), intent(in) :: long_name
         type(hdf5_series_type) :: series
         integer :: m, n

         do n = 1, n_cases
            do m = 1, n_rungs
               errors(:, m, n) = suite%rungs(rungs(m, n))%error_max(:layout%n)
               if (name == "error_median") then
                  errors(:, m, n) = suite%rungs(rungs(m, n))%error_median(:layout%n)
               end if
            end do
         end do
         call file%create_series(group // name, [n_rungs, layout%n], scales, .false., n_cases, &
            "1", long_name, series_real, series, error)
         call file%append(series, n_cases, errors, error)
      end subroutine cube

   end subroutine put_kernel

   subroutine put_bars(suite, file, error)
      type(suite_type), intent(in) :: suite
      type(hdf5_file_type), intent(inout) :: file
      type(error_type), allocatable, intent(out) :: error
      type(bar_type), allocatable :: bars(:)
      character(len=len(bars%name)), allocatable :: names(:)
      real(wp), allocatable :: numbers(:)
      integer, allocatable :: flags(:)

      bars = bars_of(suite)
      names = bars%name
      call file%create_group("/bar", error)
      call file%put_labels("/bar/name", names, "what is to be achieved", error)
      numbers = bars%measured
      call file%put_array("/bar/measured", numbers, ["/bar/name"], "1", "measured", error)
      numbers = bars%limit
      call file%put_array("/bar/limit", numbers, ["/bar/name"], "1", "bar", error)
      flags = merge(1, 0, bars%at_least)
      call file%put_array("/bar/at_least", flags, ["/bar/name"], "1", &
         "1 if it is to be at least the bar, 0 at most", error)
      flags = merge(1, 0, met(bars))
      call file%put_array("/bar/met", flags, ["/bar/name"], "1", "1 if the bar is met", error)
   end subroutine put_bars

end module contensou_drivers_bench_report
