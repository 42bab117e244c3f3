!> Manual pages for man, from the tables that make `help`.
module contensou_drivers_manual
   use contensou_base_build, only : program_version
   use contensou_base_schema, only : group_spec_type, key_type
   use contensou_base_text, only : string_type, text_buffer_type
   use contensou_drivers_command_line, only : command_type, option_type
   implicit none(type, external)
   private

   public :: program_page, scene_page

   character(len=*), parameter :: nl = new_line("a")

contains

   !> contensou(1): the commands and their options.
   function program_page(commands) result(text)
      type(command_type), intent(in) :: commands(:)
      character(len=:), allocatable :: text
      type(text_buffer_type) :: page
      integer :: i, k

      call page%add('.TH CONTENSOU 1 "" "contensou ' // program_version // '" "Contensou"' // nl)
      call page%add(".SH NAME" // nl // "contensou \- simulate rigid bodies that touch" // nl)
      call page%add(".SH SYNOPSIS" // nl // ".B contensou" // nl // ".I COMMAND" // nl // &
         "[\fIOPTION\fR...]" // nl)
      call page%add(".SH DESCRIPTION" // nl // "Contensou simulates rigid bodies with elastic " // &
         "contacts and dry friction." // nl // "A scene is a namelist file, see" // nl // &
         ".BR contensou\-scene (5);" // nl // ".B contensou new" // nl // "writes one." // nl // &
         "Results are HDF5 files." // nl)
      call page%add(".SH COMMANDS" // nl)
      do i = 1, size(commands)
         associate (command => commands(i))
            call page%add(".SS contensou " // escaped(trim(command%name)))
            do k = 1, size(command%options)
               if (.not. command%options(k)%is_option()) call page%add(" " // &
                  escaped(operand(command%options(k))))
            end do
            call page%add(nl)
            if (allocated(command%description)) then
               call add_lines(page, command%description)
            else
               call page%add(filled(trim(command%summary)))
            end if
            do k = 1, size(command%options)
               call page%add(".TP" // nl // heading(command%options(k)) // nl // &
                  filled(trim(command%options(k)%text)))
            end do
            if (allocated(command%notes)) then
               call page%add(".PP" // nl)
               call add_lines(page, command%notes)
            end if
         end associate
      end do
      call page%add(".SH EXIT STATUS" // nl)
      call add_item(page, "0", "success")
      call add_item(page, "1", "the run failed, or files differ")
      call add_item(page, "2", "bad usage, or a mistake in a scene")
      call add_item(page, "74", "a file could not be read or written")
      call add_item(page, "75", "interrupted by a signal; run --resume or sweep goes on")
      call page%add(".SH SEE ALSO" // nl // ".BR contensou\-scene (5)" // nl)
      text = page%text()
   end function program_page

   !> contensou-scene(5): the groups and keys of scenes and sweeps.
   function scene_page(groups, keys, domains) result(text)
      type(group_spec_type), intent(in) :: groups(:)
      type(key_type), intent(in) :: keys(:)
      !> Values, unit and default of each key in a few words.
      type(string_type), intent(in) :: domains(:)
      character(len=:), allocatable :: text, more
      type(text_buffer_type) :: page
      integer :: g, k

      call page%add('.TH CONTENSOU\-SCENE 5 "" "contensou ' // program_version // &
         '" "Contensou"' // nl)
      call page%add(".SH NAME" // nl // "contensou\-scene \- scenes and sweeps of contensou" // nl)
      call page%add(".SH DESCRIPTION" // nl // &
         "A scene is a Fortran namelist file in SI units, a " // &
         "sequence of groups" // nl // ".B &name key = value ... /" // nl // &
         "in which ! begins a comment and texts are in quotes." // nl // &
         "A sweep is a file of its own, with the groups that are said to be of a sweep." // nl // &
         ".B contensou help" // nl // ".I GROUP.KEY" // nl // "tells the same." // nl)
      do g = 1, size(groups)
         more = ""
         if (groups(g)%repeats) more = "; repeats"
         if (.not. groups(g)%repeats .and. .not. groups(g)%mandatory) more = "; may be left out"
         call page%add(".SH &" // escaped(trim(groups(g)%name)) // nl // &
            filled(trim(groups(g)%doc) // more // "."))
         do k = 1, size(keys)
            if (keys(k)%group == groups(g)%name) call add_item(page, trim(keys(k)%name), &
               trim(keys(k)%doc) // " (" // domains(k)%s // ")")
         end do
      end do
      call page%add(".SH SEE ALSO" // nl // ".BR contensou (1)" // nl)
      text = page%text()
   end function scene_page

   !> Add a word and what it means.
   subroutine add_item(page, word, meaning)
      type(text_buffer_type), intent(inout) :: page
      character(len=*), intent(in) :: word
      character(len=*), intent(in) :: meaning

      call page%add(".TP" // nl // ".B " // escaped(word) // nl // filled(meaning))
   end subroutine add_item

   !> Add a text; if it has several lines, they stay as they are.
   subroutine add_lines(page, text)
      type(text_buffer_type), intent(inout) :: page
      character(len=*), intent(in) :: text
      integer :: start, length

      if (index(text, nl) == 0) then
         call page%add(filled(text))
         return
      end if
      call page%add(".nf" // nl)
      start = 1
      do while (start <= len(text))
         length = index(text(start:) // nl, nl) - 1
         call page%add(escaped(text(start:start + length - 1)) // nl)
         start = start + length + 1
      end do
      call page%add(".fi" // nl)
   end subroutine add_lines

   !> An operand of a command, in brackets if it may be left out.
   pure function operand(option) result(text)
      type(option_type), intent(in) :: option
      character(len=:), allocatable :: text

      text = trim(option%name)
      if (option%needs == "") text = "[" // text // "]"
      if (option%repeats) text = text // "..."
   end function operand

   !> The line that names an option or operand.
   pure function heading(option) result(text)
      type(option_type), intent(in) :: option
      character(len=:), allocatable :: text

      if (.not. option%is_option()) then
         text = ".I " // escaped(trim(option%name))
         return
      end if
      text = "\fB" // escaped(trim(option%name)) // "\fR"
      if (option%short /= "") text = "\fB" // escaped(trim(option%short)) // "\fR, " // text
      if (.not. option%is_flag()) text = text // " \fI" // escaped(trim(option%value)) // "\fR"
   end function heading

   !> A text in lines for troff to fill, none of them long.
   pure function filled(text) result(lines)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: lines
      integer, parameter :: widest = 78
      integer :: blank, first, last

      lines = ""
      first = 1
      do
         last = len(text) + 1
         do while (len(escaped(text(first:last - 1))) > widest)
            blank = index(text(first:last - 1), " ", back=.true.)
            if (blank <= 1) exit
            last = first + blank - 1
         end do
         lines = lines // escaped(text(first:last - 1)) // nl
         first = last + 1
         if (first > len(text)) exit
      end do
   end function filled

   !> A text for troff: no character of it is a command.
   pure function escaped(text) result(safe)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: safe
      integer :: i

      safe = ""
      if (text /= "") then
         if (scan(text(1:1), ".'") > 0) safe = "\&"
      end if
      do i = 1, len(text)
         select case (text(i:i))
         case ("\")
            safe = safe // "\e"
         case ("-")
            safe = safe // "\-"
         case ("'")
            safe = safe // "\(aq"
         case ("`")
            safe = safe // "\(ga"
         case ("^")
            safe = safe // "\(ha"
         case ("~")
            safe = safe // "\(ti"
         case default
            safe = safe // text(i:i)
         end select
      end do
   end function escaped

end module contensou_drivers_manual
