!> `contensou help`: what a group or a key of a scene or a sweep means.
module contensou_drivers_help
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_operating_system, only : write_stdout
   use contensou_base_resolve, only : expected_of
   use contensou_base_schema, only : any_number, domain_text, group_spec_type, is_number, &
      key_type, kind_any, kind_choice, kind_logical, kind_name, kind_reference, kind_text
   use contensou_base_text, only : did_you_mean, join, lower, plural, quote, string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      usage_text
   use contensou_drivers_completion, only : completion_text
   use contensou_drivers_manual, only : program_page, scene_page
   use contensou_scene_schema, only : schema_groups, schema_keys
   use contensou_sweep_schema, only : sweep_groups, sweep_keys
   implicit none(type, external)
   private

   public :: help_command

   type(option_type), parameter :: options(*) = [ &
      option_type("TOPIC", "", "GROUP, GROUP.KEY or KEY of a scene or a sweep, or a command"), &
      option_type("--man", "PAGE", "manual page for man: contensou or scene", &
      needs="a page, contensou or scene", choices="contensou scene"), &
      option_type("--completion", "SHELL", "completion of the command line: bash, zsh or fish", &
      needs="a shell: bash, zsh or fish", choices="bash zsh fish")]

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou help` in the table of commands.
   function help_command() result(command)
      type(command_type) :: command

      command = command_type("help", "what a key of a scene or a sweep means", options, &
         execute=explain)
   end function help_command

   !> Explain a group or key of a scene or a sweep, or a command.
   subroutine explain(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is no such group or key.
      type(error_type), allocatable, intent(out) :: error
      type(group_spec_type), allocatable :: groups(:)
      type(key_type), allocatable :: keys(:), own(:)
      character(len=:), allocatable :: topic, text, group, key
      integer :: c, g, k, dot

      topic = line%text("TOPIC")
      groups = [schema_groups(), sweep_groups()]
      c = findloc(line%commands%name == topic, .true., dim=1)
      keys = [schema_keys(), sweep_keys()]
      if (line%has("--man") .or. line%has("--completion")) then
         call write_for_tools(line, groups, keys, error)
         return
      end if
      dot = index(topic // ".", ".")
      group = lower(topic(:dot - 1))
      key = lower(topic(dot + 1:))
      g = findloc(groups%name == group, .true., dim=1)
      own = pack(keys, keys%group == group)
      k = findloc(own%name == key, .true., dim=1)
      if (group == "") then
         text = overview(groups, keys)
      else if (c > 0 .and. all(groups%name /= topic)) then
         ! What is a group, too, is explained as that.
         text = usage_text(line%commands(c)) // nl
      else if (g == 0 .and. key == "" .and. any(keys%name == group)) then
         ! A key alone: in all groups that have it.
         own = pack(keys, keys%name == group)
         text = key_text(own(1))
         do k = 2, size(own)
            text = text // nl // key_text(own(k))
         end do
      else if (g == 0) then
         call fatal(error, "a scene or sweep has no group " // quote(group) // &
            did_you_mean(group, groups%name, "contensou help lists them"), status_usage)
      else if (key == "") then
         text = group_text(groups(g))
         do k = 1, size(own)
            text = text // nl // key_text(own(k))
         end do
         c = findloc(line%commands%name == group, .true., dim=1)
         if (c > 0) text = text // nl // "The command of this name:" // nl // nl // &
            usage_text(line%commands(c)) // nl
      else if (k == 0) then
         call fatal(error, "group " // quote(group) // " has no key " // quote(key) // &
            did_you_mean(key, own%name, "contensou help " // group // " lists them"), status_usage)
      else
         text = key_text(own(k))
      end if
      if (.not. allocated(error)) call write_stdout(text, error)
   end subroutine explain

   !> Write a manual page, or what a shell needs to complete command lines.
   subroutine write_for_tools(line, groups, keys, error)
      type(command_line_type), intent(in) :: line
      type(group_spec_type), intent(in) :: groups(:)
      type(key_type), intent(in) :: keys(:)
      !> Set when there is no such page or shell.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: text, page
      type(string_type) :: texts(size(keys))
      integer :: k

      if (line%has("--completion")) then
         text = completion_text(line%text("--completion"), line%commands, groups%name)
         if (text == "") call fatal(error, "there is no completion for " // &
            quote(line%text("--completion")) // ", only for bash, zsh and fish", status_usage)
      else
         page = line%text("--man")
         select case (page)
         case ("contensou")
            text = program_page(line%commands)
         case ("scene")
            do k = 1, size(keys)
               texts(k)%s = short_domain(keys(k))
            end do
            text = scene_page(groups, keys, texts)
         case default
            call fatal(error, "there is no page " // quote(page) // ", only contensou and scene", &
               status_usage)
         end select
      end if
      if (.not. allocated(error)) call write_stdout(text, error, as_is=.true.)
   end subroutine write_for_tools

   !> All groups and their keys.
   function overview(groups, keys) result(text)
      type(group_spec_type), intent(in) :: groups(:)
      type(key_type), intent(in) :: keys(:)
      character(len=:), allocatable :: text
      integer :: g, k

      text = "A scene is a Fortran namelist file: groups &name key = value ... /, SI units." // nl
      do g = 1, size(groups)
         if (groups(g)%name == "sweep") text = text // nl // &
            "A sweep is a file of its own, with these groups." // nl
         text = text // nl // group_text(groups(g))
         do k = 1, size(keys)
            if (keys(k)%group == groups(g)%name) text = text // "    " // keys(k)%name // &
               short_domain(keys(k)) // nl
         end do
      end do
      text = text // nl // "contensou help GROUP.KEY tells more." // nl
   end function overview

   !> A group in a line.
   pure function group_text(group) result(text)
      type(group_spec_type), intent(in) :: group
      character(len=:), allocatable :: text

      text = "&" // trim(group%name) // ": " // trim(group%doc)
      if (group%repeats) text = text // "; repeats"
      if (.not. group%repeats .and. .not. group%mandatory) text = text // "; may be left out"
      text = text // nl
   end function group_text

   !> Values and unit of a key in a few words.
   function short_domain(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      select case (key%kind)
      case (kind_any)
         text = expected_of(key)
      case (kind_choice)
         text = join(key%names(), " | ")
      case (kind_logical)
         text = ".true. | .false."
      case (kind_reference)
         text = "name of a " // trim(key%target)
         if (key%values == 2) text = "names of two " // plural(key%target)
      case (kind_name)
         text = "a name"
      case default
         text = "a text"
         if (is_number(key)) text = domain_text(key)
         if (key%kind == kind_text .and. key%values == any_number) text = expected_of(key)
      end select
      if (key%mandatory) then
         text = text // ", mandatory"
      else if (key%default /= "") then
         text = text // ", default " // trim(key%default)
      end if
   end function short_domain

   !> All about a key.
   function key_text(key) result(text)
      type(key_type), intent(in) :: key
      character(len=:), allocatable :: text

      text = trim(key%group) // "." // trim(key%name) // nl // "    " // trim(key%doc) // nl // &
         "    " // short_domain(key) // nl
   end function key_text

end module contensou_drivers_help
