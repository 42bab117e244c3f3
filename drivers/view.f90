!> `contensou view`: an output file as a page that shows it.
module contensou_drivers_view
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_operating_system, only : become
   use contensou_base_text, only : string_type
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type
   implicit none(type, external)
   private

   public :: view_command

   type(option_type), parameter :: options(*) = [ &
      option_type("FILE.h5", "", "output file of a run, also of one that goes on (.part), or " // &
      "the table of a sweep"), &
      option_type("--output", "HTML", "page to write; default beside FILE.h5, as .html", "-o", &
      "the name of a file"), &
      option_type("--limit-surface", "SPOT", "in place of a file: the forces and torques of " // &
      "friction that a spot can take, as a=2e-3,b=1e-3,f=0.3,N=10; also model=", &
      needs="a spot as a=2e-3,b=1e-3,f=0.3,N=10")]

   !> Does it.
   character(len=*), parameter :: tool = "contensou-view"

contains

   !> `contensou view` in the table of commands.
   function view_command() result(command)
      type(command_type) :: command

      command = command_type("view", "show a run in a browser", options, &
         "writes one HTML file that shows the bodies of a run, or the cases of a sweep, in a " // &
         "browser and without a network, and prints its name", &
         "contensou view ball.h5" // new_line("a") // &
         "contensou view ball.h5.part -o so_far.html", execute=view)
   end function view_command

   !> Write the page: another program does.
   subroutine view(line, error)
      type(command_line_type), intent(in) :: line
      !> Set when there is nothing to show, or that program is not found.
      type(error_type), allocatable, intent(out) :: error
      type(string_type) :: words(4)
      character(len=:), allocatable :: trouble
      integer :: n

      if (line%has("--limit-surface") .eqv. line%text("FILE.h5") /= "") then
         call fatal(error, "view needs either FILE.h5 or --limit-surface", status_usage)
         return
      end if
      n = 0
      if (line%text("--output") /= "") call put("--output=" // line%text("--output"))
      if (line%has("--limit-surface")) then
         call put("--limit-surface=" // line%text("--limit-surface"))
      else
         ! No name of a file is an option.
         call put("--")
         call put(line%text("FILE.h5"))
      end if
      call become(tool, words(:n), trouble)
      call fatal(error, "cannot start " // tool // ", which writes the page: " // trouble // &
         "; it comes with the program, in the folder of its executable", status_file)

   contains

      !> Add a word.
      subroutine put(word)
         character(len=*), intent(in) :: word

         n = n + 1
         words(n)%s = word
      end subroutine put

   end subroutine view

end module contensou_drivers_view
