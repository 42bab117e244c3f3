!> Files that commands write whole: a temporary name until they are complete, and stdout in place of
!> a file.
module contensou_drivers_output
   use contensou_base_errors, only : error_type, fatal, status_file
   use contensou_base_operating_system, only : check_writable, file_exists, is_terminal, &
      longest_temporary, remove_file, rename_file, sweep_up, temporary_name, write_stdout
   use contensou_base_output_path, only : check_output_path, what_helps
   use contensou_base_text, only : string_type
   implicit none(type, external)
   private

   public :: output_type, check_output, write_text

   !> A file that grows piece by piece and has its name when it is complete, or stdout.
   type :: output_type
      private
      !> Its name; empty for stdout.
      character(len=:), allocatable :: name
      character(len=:), allocatable :: temporary
      logical :: replace = .false.
      integer :: unit = 0
   contains
      procedure :: open => open_output
      procedure :: write => write_output
      procedure :: finish
      procedure :: abandon
   end type output_type

contains

   !> Begin a file.
   subroutine open_output(self, name, inputs, force, error)
      class(output_type), intent(inout) :: self
      !> Name of the file; empty or - for stdout.
      character(len=*), intent(in) :: name
      !> Names of the files that are read.
      type(string_type), intent(in) :: inputs(:)
      !> Whether it may replace an existing one.
      logical, intent(in) :: force
      !> Set when it is not to be written, or cannot be.
      type(error_type), allocatable, intent(out) :: error
      character(len=200) :: message
      integer :: stat

      self%name = name
      if (name == "-") self%name = ""
      self%replace = force
      if (self%name == "") return
      call check_output(name, inputs, force, error)
      if (allocated(error)) return
      call sweep_up(name)
      self%temporary = temporary_name(name)
      open(newunit=self%unit, file=self%temporary, access="stream", form="unformatted", &
         action="write", status="replace", iostat=stat, iomsg=message)
      if (stat == 0) return
      call fatal(error, "cannot write " // self%temporary // ": " // trim(message), status_file)
      deallocate(self%temporary)
   end subroutine open_output

   !> Add a piece, as it stands; a terminal is not to obey what is in it.
   subroutine write_output(self, text, error)
      class(output_type), intent(inout) :: self
      character(len=*), intent(in) :: text
      type(error_type), allocatable, intent(out) :: error
      character(len=200) :: message
      integer :: stat

      if (self%name == "") then
         call write_stdout(text, error, as_is=.not. is_terminal(1))
         return
      end if
      write(self%unit, iostat=stat, iomsg=message) text
      ! A full disk may show only now.
      if (stat == 0) flush(self%unit, iostat=stat, iomsg=message)
      if (stat /= 0) call fatal(error, "cannot write " // self%temporary // ": " // &
         trim(message), status_file)
   end subroutine write_output

   !> Give the complete file its name.
   subroutine finish(self, error)
      class(output_type), intent(inout) :: self
      type(error_type), allocatable, intent(out) :: error
      character(len=200) :: message
      integer :: stat

      if (.not. allocated(self%temporary)) return
      close(self%unit, iostat=stat, iomsg=message)
      if (stat /= 0) then
         call fatal(error, "cannot write " // self%temporary // ": " // trim(message), status_file)
      else
         call rename_file(self%temporary, self%name, error, self%replace)
      end if
      if (.not. allocated(error)) deallocate(self%temporary)
   end subroutine finish

   !> Give the file up; nothing is done to a finished one.
   subroutine abandon(self)
      class(output_type), intent(inout) :: self
      type(error_type), allocatable :: ignored

      if (.not. allocated(self%temporary)) return
      close(self%unit)
      call remove_file(self%temporary, ignored)
      deallocate(self%temporary)
   end subroutine abandon

   !> See that a file can be written and that nothing is lost by it.
   subroutine check_output(name, inputs, force, error)
      character(len=*), intent(in) :: name
      !> Names of the files that are read.
      type(string_type), intent(in) :: inputs(:)
      !> Whether it may replace an existing one.
      logical, intent(in) :: force
      !> Set when it is not to be written.
      type(error_type), allocatable, intent(out) :: error

      call check_output_path(name, "output file", inputs, [longest_temporary], force, error)
      if (.not. allocated(error)) call check_writable(name, "output file", error)
      if (allocated(error) .or. force) return
      if (file_exists(name)) call fatal(error, name // " exists" // what_helps(name), status_file)
   end subroutine check_output

   !> Write a text file.
   subroutine write_text(name, text, error)
      character(len=*), intent(in) :: name
      character(len=*), intent(in) :: text
      type(error_type), allocatable, intent(out) :: error
      character(len=200) :: message
      integer :: unit, stat

      open(newunit=unit, file=name, access="stream", form="unformatted", action="write", &
         status="replace", iostat=stat, iomsg=message)
      if (stat == 0) then
         write(unit, iostat=stat, iomsg=message) text
         ! A full disk may show only now.
         if (stat == 0) flush(unit, iostat=stat, iomsg=message)
         if (stat == 0) then
            close(unit, iostat=stat, iomsg=message)
         else
            close(unit)
         end if
      end if
      if (stat /= 0) call fatal(error, "cannot write " // name // ": " // trim(message), &
         status_file)
   end subroutine write_text

end module contensou_drivers_output
