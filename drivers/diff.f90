!> `contensou diff`: compare two output files.
!>
!> The work is done by a worker process, because HDF5 can crash, hang or take all memory over a
!> damaged file. Exit status: 0 same, 1 different, 2 trouble of any kind.
module contensou_drivers_diff
   use contensou_base_errors, only : error_type, fatal, status_failed, status_ok, status_usage
   use contensou_base_guard, only : finish_guard, start_guard, wait_for_worker
   use contensou_base_kinds, only : wp
   use contensou_base_operating_system, only : write_stderr, write_stdout
   use contensou_base_text, only : join, string_type, strings
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      takes_number
   use contensou_compare_comparison, only : comparison_type
   use contensou_compare_listing, only : comparison_output_type
   use contensou_compare_rules, only : built_in_rules, built_in_text, read_rules, &
      whole_run_text
   implicit none(type, external)
   private

   public :: diff_command

   type(option_type), parameter :: options(*) = [ &
      option_type("A.h5", "", "output file", needs="a file"), &
      option_type("B.h5", "", "output file", needs="two files"), &
      option_type("--rules", "FILE", "lines PATTERN ATOL RTOL or PATTERN ignore, # for " // &
      "comments; the last that matches wins; |a - b| <= ATOL + RTOL max(|a|, |b|)", &
      needs="the name of a file"), &
      option_type("--until", "T", "leave out rows and events after the time T [s]", &
      needs="a time [s]", takes=takes_number), &
      option_type("--quiet", "", "no results on stdout", "-q")]

   !> What the user asks for, in the words of the options.
   type :: diff_config_type
      type(string_type) :: files(2)
      character(len=:), allocatable :: rules
      logical :: has_until = .false., quiet = .false.
      real(wp) :: until = 0.0_wp
   end type diff_config_type

   !> Results on stdout, trouble on stderr.
   type, extends(comparison_output_type) :: terminal_output_type
      !> Whether results are not wanted.
      logical :: quiet = .false.
      !> Why stdout takes no more.
      type(error_type), allocatable :: error
   contains
      procedure :: line => write_line
      procedure :: trouble => write_trouble
   end type terminal_output_type

   !> Memory that the worker may use [bytes].
   real(wp), parameter :: memory = 1073741824.0_wp

contains

   !> `contensou diff` in the table of commands.
   function diff_command() result(command)
      type(command_type) :: command
      character(len=*), parameter :: nl = new_line("a"), before = nl // "  "
      character(len=:), allocatable :: notes
      type(string_type), allocatable :: rules(:)

      ! In steps: gfortran does not free what functions return inside of a structure constructor.
      rules = strings(built_in_text)
      notes = "built-in rules, which only a rule without * ? [ outdoes:" // before // &
         join(rules, before) // nl // "and with --until, which none outdoes:" // before
      rules = strings(whole_run_text)
      notes = notes // join(rules, before)
      command = command_type("diff", "compare two output files", options, &
         "compares all data sets and attributes, exactly unless a rule says otherwise;" // nl // &
         "exit status 0 same, 1 different, 2 trouble", notes, execute=diff)
   end function diff_command

   !> Compare two files.
   subroutine diff(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is trouble, or without words when they differ.
      type(error_type), allocatable, intent(out) :: error
      type(diff_config_type) :: config
      type(comparison_type) :: comparison
      character(len=:), allocatable :: place, reason, output
      integer :: status
      logical :: is_worker, finished, inside

      config%files(1)%s = line%text("A.h5")
      config%files(2)%s = line%text("B.h5")
      config%rules = line%text("--rules")
      config%has_until = line%has("--until")
      config%until = line%number("--until", config%until)
      config%quiet = line%has("--quiet")
      call built_in_rules(config%has_until, comparison%rules)
      if (config%rules /= "") call read_rules(config%rules, comparison%rules, error)
      if (.not. allocated(error)) call start_guard(memory, is_worker, error)
      if (allocated(error)) then
         error%status = status_usage
         return
      end if
      if (is_worker) then
         call compare(config, comparison, status)
         call finish_guard(status)
      end if
      call wait_for_worker(finished, status, inside, place, reason, output)
      if (finished) then
         call write_stderr(output)
         if (status /= status_ok) call fatal(error, "", status)
      else if (inside) then
         call fatal(error, "cannot read " // place // ": the HDF5 library failed (" // reason // &
            "); this file or the other one is damaged", status_usage)
      else
         call write_stderr(output)
         call fatal(error, "the comparison failed after reading " // place // " (" // reason // &
            "): the file is damaged, or this is a mistake in the program", status_usage)
      end if
   end subroutine diff

   !> Compare two files in the worker.
   subroutine compare(config, comparison, status)
      type(diff_config_type), intent(in) :: config
      !> The comparison with its rules.
      type(comparison_type), intent(inout) :: comparison
      integer, intent(out) :: status
      type(terminal_output_type), target :: output
      type(error_type), allocatable :: error

      output%quiet = config%quiet
      comparison%span%is_cut = config%has_until
      comparison%span%until = config%until
      call comparison%run(config%files, output, error)
      if (.not. allocated(error) .and. allocated(output%error)) then
         call move_alloc(output%error, error)
      end if
      if (allocated(error)) then
         call write_stderr("error: " // error%message // new_line("a"))
         status = status_usage
      else if (comparison%listing%n_trouble > 0) then
         status = status_usage
      else if (comparison%different()) then
         status = status_failed
      else
         status = status_ok
      end if
   end subroutine compare

   !> Write a line of results.
   subroutine write_line(self, text)
      class(terminal_output_type), intent(inout) :: self
      character(len=*), intent(in) :: text

      if (self%quiet .or. self%broken) return
      call write_stdout(text // new_line("a"), self%error)
      self%broken = allocated(self%error)
   end subroutine write_line

   !> Write a message about what could not be compared.
   subroutine write_trouble(self, text)
      class(terminal_output_type), intent(inout) :: self
      character(len=*), intent(in) :: text

      call write_stderr("error: " // text // new_line("a"))
   end subroutine write_trouble

end module contensou_drivers_diff
