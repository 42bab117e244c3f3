!> `contensou models`: the models that a scene can name.
module contensou_drivers_models
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_operating_system, only : write_stdout
   use contensou_base_text, only : did_you_mean, lower, quote
   use contensou_contact_catalogue, only : model_info_type
   use contensou_contact_creep, only : creep_model_type, creep_models
   use contensou_contact_hertz, only : hertz_model_type
   use contensou_contact_pairs, only : geometry_models
   use contensou_contact_parts, only : contact_parts, part_type
   use contensou_contact_vilke, only : vilke_models
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type
   implicit none(type, external)
   private

   public :: models_command

   type(option_type), parameter :: options(*) = [ &
      option_type("NAME", "", "only this model")]

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou models` in the table of commands.
   function models_command() result(command)
      type(command_type) :: command

      command = command_type("models", "the models that a scene can name", options, &
         execute=list_models)
   end function models_command

   subroutine list_models(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is no such model.
      type(error_type), allocatable, intent(out) :: error
      type(part_type), allocatable :: parts(:)
      type(hertz_model_type), allocatable :: vilke(:)
      type(creep_model_type), allocatable :: creep(:)
      character(len=:), allocatable :: name, text
      character(len=24), allocatable :: names(:)
      integer :: i, j

      name = line%text("NAME")
      parts = contact_parts()
      vilke = vilke_models()
      creep = creep_models()
      text = ""
      allocate(names(0))
      call list("surfaces (contact.surfaces)", geometry_models())
      do i = 1, size(parts)
         call list(trim(parts(i)%doc) // " (contact." // trim(parts(i)%name) // ")", &
            parts(i)%described())
         if (parts(i)%name == "normal") call list("spot of vilke (contact.ellipse)", vilke%info)
         if (parts(i)%name == "tangential") call list("law of creep (contact.creep)", &
            [(creep(j)%described(), j=1, size(creep))])
      end do
      if (text == "") then
         call fatal(error, "there is no model " // quote(name) // &
            did_you_mean(name, names, "contensou models lists them"), status_usage)
         return
      end if
      call write_stdout(text, error)

   contains

      !> Add a table, or the entry that is asked for.
      subroutine list(title, info)
         !> Title of the table.
         character(len=*), intent(in) :: title
         type(model_info_type), intent(in) :: info(:)
         integer :: i
         logical :: first

         first = .true.
         names = [names, info%name]
         do i = 1, size(info)
            if (name /= "" .and. lower(name) /= info(i)%name) cycle
            if (first) text = text // title // nl
            first = .false.
            text = text // "  " // trim(info(i)%name) // nl
            text = text // "      " // trim(info(i)%summary) // nl
            if (info(i)%keys /= "") text = text // "      keys: " // trim(info(i)%keys) // nl
            if (info(i)%states /= "") text = text // "      states: " // trim(info(i)%states) // nl
            if (info(i)%reference /= "") text = text // "      reference: " // &
               trim(info(i)%reference) // nl
         end do
      end subroutine list

   end subroutine list_models

end module contensou_drivers_models
