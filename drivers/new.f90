!> `contensou new`: a commented scene to begin with. The scenes are the files in drivers/templates.
module contensou_drivers_new
   use, intrinsic :: iso_c_binding, only : c_int, c_ptr
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_operating_system, only : text_from_c
   use contensou_base_text, only : lower, nearest, quote, string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type
   use contensou_drivers_output, only : output_type
   implicit none(type, external)
   private

   public :: new_command

   type(option_type), parameter :: options(*) = [ &
      option_type("TEMPLATE", "", "which scene; ball if not given"), &
      option_type("--output", "FILE", "file to write; the terminal if not given", "-o", &
      "the name of a file"), &
      option_type("--force", "", "replace an existing file")]

   interface
      !> Number of scenes.
      pure integer(c_int) function c_count() bind(c, name="contensou_template_count")
         import :: c_int
         implicit none(type, external)
      end function c_count

      !> Name of a scene.
      type(c_ptr) function c_name(i) bind(c, name="contensou_template_name")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> Index, from 0.
         integer(c_int), value :: i
      end function c_name

      !> Text of a scene.
      type(c_ptr) function c_text(i) bind(c, name="contensou_template_text")
         import :: c_int, c_ptr
         implicit none(type, external)
         !> Index, from 0.
         integer(c_int), value :: i
      end function c_text
   end interface

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou new` in the table of commands.
   function new_command() result(command)
      type(command_type) :: command
      type(option_type) :: with_names(size(options))
      ! gfortran 12 does not free a function's text in a structure constructor.
      character(len=:), allocatable :: text
      integer :: i

      with_names = options
      do i = 1, c_count()
         with_names(1)%choices = trim(with_names(1)%choices) // " " // &
            text_from_c(c_name(i - 1_c_int))
      end do
      text = "writes a commented scene to begin with:" // nl // template_list()
      command = command_type("new", "write a commented scene to begin with", with_names, text, &
         "contensou new ball -o my_ball.nml" // nl // "contensou run my_ball.nml", &
         execute=write_template)
   end function new_command

   !> The templates with what they are, a line each.
   function template_list() result(text)
      character(len=:), allocatable :: text
      character(len=:), allocatable :: name, scene
      integer :: i

      text = ""
      do i = 1, c_count()
         name = text_from_c(c_name(i - 1_c_int))
         scene = text_from_c(c_text(i - 1_c_int))
         if (i > 1) text = text // nl
         text = text // "  " // name // repeat(" ", max(12 - len(name), 1)) // &
            scene(3:index(scene, nl) - 2)
      end do
   end function template_list

   subroutine write_template(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is no such template, or it cannot be written.
      type(error_type), allocatable, intent(out) :: error
      type(output_type) :: output
      type(string_type) :: names(c_count())
      type(string_type) :: none(0)
      character(len=:), allocatable :: word
      integer :: i, found

      word = line%text("TEMPLATE")
      found = 0
      do i = 1, size(names)
         names(i)%s = text_from_c(c_name(i - 1_c_int))
         if (names(i)%s == lower(word)) found = i
      end do
      if (.not. line%has("TEMPLATE")) found = 1
      if (found == 0) then
         i = nearest(word, names)
         if (i > 0) then
            call fatal(error, "there is no template " // quote(word) // "; did you mean " // &
               quote(names(i)%s) // "?", status_usage)
         else
            call fatal(error, "there is no template " // quote(word) // ", only" // nl // &
               template_list(), status_usage)
         end if
         return
      end if
      call output%open(line%text("--output"), none, line%has("--force"), error)
      if (allocated(error)) return
      call output%write(text_from_c(c_text(found - 1_c_int)), error)
      if (.not. allocated(error)) call output%finish(error)
      call output%abandon()
   end subroutine write_template

end module contensou_drivers_new
