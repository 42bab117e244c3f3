!> Completion of command lines by bash, zsh and fish, from the tables that make `help`.
module contensou_drivers_completion
   use contensou_base_text, only : text_buffer_type
   use contensou_drivers_command_line, only : command_type, option_type
   implicit none(type, external)
   private

   public :: completion_text

   character(len=*), parameter :: nl = new_line("a")

contains

   !> What a shell needs; empty if it is none of those that are known.
   function completion_text(shell, commands, groups) result(text)
      character(len=*), intent(in) :: shell
      type(command_type), intent(in) :: commands(:)
      !> Groups of scenes and sweeps.
      character(len=*), intent(in) :: groups(:)
      character(len=:), allocatable :: text

      select case (shell)
      case ("bash")
         text = for_bash(commands, groups)
      case ("zsh")
         text = for_zsh(commands, groups)
      case ("fish")
         text = for_fish(commands, groups)
      case default
         text = ""
      end select
   end function completion_text

   !> Words that are proposed for an option or operand; blank for names of files.
   function choices_of(command, option, commands, groups) result(words)
      type(command_type), intent(in) :: command
      type(option_type), intent(in) :: option
      type(command_type), intent(in) :: commands(:)
      character(len=*), intent(in) :: groups(:)
      character(len=:), allocatable :: words
      integer :: i

      words = trim(adjustl(option%choices))
      if (command%name /= "help" .or. option%name /= "TOPIC") return
      do i = 1, size(groups)
         words = words // " " // trim(groups(i))
      end do
      do i = 1, size(commands)
         if (all(groups /= commands(i)%name)) words = words // " " // trim(commands(i)%name)
      end do
      words = trim(adjustl(words))
   end function choices_of

   !> For bash, with nothing but its own `complete` and `compgen`.
   function for_bash(commands, groups) result(text)
      type(command_type), intent(in) :: commands(:)
      character(len=*), intent(in) :: groups(:)
      character(len=:), allocatable :: text
      type(text_buffer_type) :: script
      character(len=:), allocatable :: options, names
      integer :: i, k

      call script%add("# Completion of contensou for bash." // nl // "_contensou()" // nl // "{" &
         // nl // "   local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}" // &
         nl // "   local command=${COMP_WORDS[1]} words=" // nl // "   COMPREPLY=()" // nl // &
         "   if [ ""$COMP_CWORD"" -eq 1 ]; then" // nl // "      words='")
      do i = 1, size(commands)
         call script%add(trim(commands(i)%name) // " ")
      end do
      call script%add("--help --version'" // nl // "   else" // nl // &
         "      case $command:$before in" // nl)
      ! Values of options, then operands and options.
      do i = 1, size(commands)
         do k = 1, size(commands(i)%options)
            associate (option => commands(i)%options(k))
               if (.not. option%is_option() .or. option%is_flag()) cycle
               names = trim(commands(i)%name) // ":" // trim(option%name)
               if (option%short /= "") names = names // " | " // trim(commands(i)%name) // ":" // &
                  trim(option%short)
               call script%add("      " // names // ") words='" // &
                  choices_of(commands(i), option, commands, groups) // "' ;;" // nl)
            end associate
         end do
      end do
      do i = 1, size(commands)
         options = "--help"
         names = ""
         do k = 1, size(commands(i)%options)
            associate (option => commands(i)%options(k))
               if (option%is_option()) then
                  options = options // " " // trim(option%name)
                  if (option%short /= "") options = options // " " // trim(option%short)
               else
                  names = trim(names // " " // choices_of(commands(i), option, commands, groups))
               end if
            end associate
         end do
         call script%add("      " // trim(commands(i)%name) // ":*)" // nl // &
            "         words='" // trim(adjustl(names)) // "'" // nl // &
            "         case $word in -*) words='" // options // "' ;; esac" // nl // &
            "         ;;" // nl)
      end do
      call script%add("      esac" // nl // "   fi" // nl // &
         "   if [ -n ""$words"" ]; then" // nl // &
         "      mapfile -t COMPREPLY < <(compgen -W ""$words"" -- ""$word"")" // nl // "   else" &
         // nl // "      compopt -o filenames 2>/dev/null" // nl // &
         "      mapfile -t COMPREPLY < <(compgen -f -- ""$word"")" // nl // "   fi" // nl // "}" &
         // nl // "complete -F _contensou contensou" // nl)
      text = script%text()
   end function for_bash

   !> For zsh, by its `_arguments`.
   function for_zsh(commands, groups) result(text)
      type(command_type), intent(in) :: commands(:)
      character(len=*), intent(in) :: groups(:)
      character(len=:), allocatable :: text
      type(text_buffer_type) :: script
      character(len=:), allocatable :: names, value
      integer :: i, k

      call script%add("#compdef contensou" // nl // "# Completion of contensou for zsh." // nl // &
         "local context state line" // nl // "local -a commands" // nl // "commands=(" // nl)
      do i = 1, size(commands)
         call script%add("   '" // trim(commands(i)%name) // ":" // &
            in_quotes(trim(commands(i)%summary)) // "'" // nl)
      end do
      call script%add(")" // nl // "_arguments -C '(- *)--help[usage]' '(- *)--version[version]' " &
         // "'1:command:->command' '*::argument:->argument'" // nl // "case $state in" // nl // &
         "command) _describe command commands ;;" // nl // "argument)" // nl // &
         "   case $words[1] in" // nl)
      do i = 1, size(commands)
         call script%add("   " // trim(commands(i)%name) // ") _arguments '--help[usage]'")
         do k = 1, size(commands(i)%options)
            associate (option => commands(i)%options(k))
               value = choices_of(commands(i), option, commands, groups)
               if (value == "") then
                  value = "_files"
               else
                  value = "(" // value // ")"
               end if
               call script%add(" \" // nl // "      ")
               if (option%is_option()) then
                  names = "'*"
                  if (.not. option%repeats) names = "'"
                  if (option%short /= "") then
                     if (.not. option%repeats) names = "'(" // trim(option%short) // " " // &
                        trim(option%name) // ")"
                     names = names // "'{" // trim(option%short) // "," // trim(option%name) // "}'"
                  else
                     names = names // trim(option%name)
                  end if
                  call script%add(names // "[" // in_quotes(trim(option%text)) // "]")
                  if (.not. option%is_flag()) call script%add(":" // trim(option%value) // ":" // &
                     value)
                  call script%add("'")
               else
                  names = "':"
                  if (option%repeats) names = "'*:"
                  call script%add(names // trim(option%name) // ":" // value // "'")
               end if
            end associate
         end do
         call script%add(" ;;" // nl)
      end do
      call script%add("   esac" // nl // "   ;;" // nl // "esac" // nl)
      text = script%text()
   end function for_zsh

   function for_fish(commands, groups) result(text)
      type(command_type), intent(in) :: commands(:)
      character(len=*), intent(in) :: groups(:)
      character(len=:), allocatable :: text
      type(text_buffer_type) :: script
      character(len=:), allocatable :: words
      character(len=*), parameter :: first = "complete -c contensou -f -n __fish_use_subcommand "
      integer :: i, k

      call script%add("# Completion of contensou for fish." // nl // first // "-l help" // nl // &
         first // "-l version" // nl)
      do i = 1, size(commands)
         call script%add(first // "-a " // trim(commands(i)%name) // " -d '" // &
            quoted(trim(commands(i)%summary)) // "'" // nl)
      end do
      do i = 1, size(commands)
         do k = 1, size(commands(i)%options)
            associate (option => commands(i)%options(k))
               words = choices_of(commands(i), option, commands, groups)
               if (.not. option%is_option() .and. words == "") cycle
               call script%add("complete -c contensou -n '__fish_seen_subcommand_from " // &
                  trim(commands(i)%name) // "'")
               if (option%is_option()) then
                  call script%add(" -l " // trim(option%name(3:)))
                  if (option%short /= "") call script%add(" -s " // option%short(2:))
                  if (.not. option%is_flag()) call script%add(" -r")
               end if
               if (words /= "") call script%add(" -f -a '" // words // "'")
               call script%add(" -d '" // quoted(trim(option%text)) // "'" // nl)
            end associate
         end do
      end do
      text = script%text()
   end function for_fish

   !> A text for the quotes of fish.
   pure function quoted(text) result(safe)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: safe
      integer :: i

      safe = ""
      do i = 1, len(text)
         if (scan(text(i:i), "'\") > 0) safe = safe // "\"
         safe = safe // text(i:i)
      end do
   end function quoted

   !> A text for the quotes of zsh, and the brackets and colons of _arguments in them.
   pure function in_quotes(text) result(safe)
      character(len=*), intent(in) :: text
      character(len=:), allocatable :: safe
      integer :: i

      safe = ""
      do i = 1, len(text)
         if (text(i:i) == "'") then
            safe = safe // "'\''"
         else
            if (scan(text(i:i), "[]:\") > 0) safe = safe // "\"
            safe = safe // text(i:i)
         end if
      end do
   end function in_quotes

end module contensou_drivers_completion
