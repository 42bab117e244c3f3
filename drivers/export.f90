!> `contensou export`: an output file in another format.
module contensou_drivers_export
   use contensou_base_errors, only : error_type, fatal, status_file, status_usage
   use contensou_base_kinds, only : i8
   use contensou_base_numbers, only : counted
   use contensou_base_operating_system, only : become, write_stderr, write_stdout
   use contensou_base_text, only : did_you_mean, join, quote, string_type, strings
   use contensou_drivers_command_line, only : command_line_type, command_type, option_type, &
      takes_count, takes_number
   use contensou_drivers_output, only : output_type
   use contensou_files_columns, only : tables_type
   implicit none(type, external)
   private

   public :: export_command

   type(option_type), parameter :: options(*) = [ &
      option_type("FILE.h5", "", "output file of a run, a sweep or a cost study", needs="a file"), &
      option_type("--to", "FORMAT", "csv: comma-separated values, a line for each row; gltf: " // &
      "bodies that move, glTF 2 in one file (.glb); vtk: with forces and spots (.vtkhdf); " // &
      "video: a film (.mp4), or its frames in a folder", &
      needs="a format", choices="csv gltf vtk video"), &
      option_type("--csv", "", "the same as --to csv"), &
      option_type("--video", "", "the same as --to video"), &
      option_type("--output", "FILE", "file to write; if not given the terminal for csv, else " // &
      "a file beside FILE.h5", "-o", "the name of a file"), &
      option_type("--columns", "NAMES", "columns, separated by commas, in their order; names " // &
      "of data sets or columns, * for any characters, ? for one; default all", "-c", &
      "names of columns", repeats=.true.), &
      option_type("--list", "", "list the columns, their units and meanings instead"), &
      option_type("--from", "T", "gltf, vtk, video: begin at this time [s]", needs="a time [s]", &
      takes=takes_number), &
      option_type("--until", "T", "gltf, vtk, video: end at this time [s]", needs="a time [s]", &
      takes=takes_number), &
      option_type("--frames", "N", "vtk: so many rows, evenly spread; default 500", &
      needs="a whole number from 1 to 999999", takes=takes_count), &
      option_type("--all", "", "gltf, vtk: all rows; gltf else has those that it takes to be " // &
      "within 1 degree and a thousandth of the scene"), &
      option_type("--rate", "R", "video: frames a second; default 30", &
      needs="a number > 0", takes=takes_number), &
      option_type("--speed", "S", "video: so many times as fast as real time; default 1", &
      needs="a number > 0", takes=takes_number), &
      option_type("--size", "WxH", "video: pixels, even numbers; default 1280x720", &
      needs="pixels as 1280x720"), &
      option_type("--camera", "NAME", "video: what the camera does; default follow", &
      needs="a camera", choices="orbit follow ride fit"), &
      option_type("--force", "", "replace an existing file")]

   !> Formats that can be written, and the endings of files that tell them.
   character(len=*), parameter :: formats(*) = [character(len=5) :: "csv", "gltf", "vtk", "video"]
   character(len=*), parameter :: endings(*) = [character(len=6) :: "csv", "glb", "vtkhdf", "mp4"]

   !> Options of formats of bodies, and those of films alone, which are some of the former.
   character(len=*), parameter :: options_of_bodies(*) = [character(len=11) :: "--from", &
      "--until", "--frames", "--all", "--rate", "--speed", "--size", "--camera"]
   character(len=*), parameter :: options_of_films(*) = options_of_bodies(5:)

   !> What the user asks for, in the words of the options.
   type :: export_config_type
      character(len=:), allocatable :: file, format, output
      !> Words of `--columns`.
      type(string_type), allocatable :: columns(:)
      logical :: list = .false., force = .false.
   end type export_config_type

   character(len=*), parameter :: nl = new_line("a")

contains

   !> `contensou export` in the table of commands.
   function export_command() result(command)
      type(command_type) :: command

      command = command_type("export", "write an output file in another format", options, &
         "writes columns of an output file: the trajectory of a run, the cases of a sweep or " // &
         "the runs of a cost study, as numbers that read back to the same bits; or the bodies " // &
         "of a run and their motion for programs that draw them", &
         "contensou export ball.h5 --csv --columns time,position,gap_ball_floor -o ball.csv" // &
         nl // "contensou export ball.h5 --csv --columns 'events/*'" // nl // &
         "contensou export ball.h5 --to gltf -o ball.glb", execute=export)
   end function export_command

   !> Write a file in another format.
   subroutine export(line, error)
      type(command_line_type), intent(in) :: line
      type(error_type), allocatable, intent(out) :: error
      type(export_config_type) :: config
      type(tables_type) :: tables

      call configure(line, config, error)
      if (allocated(error)) return
      if (config%format /= "csv" .and. .not. config%list) then
         call write_bodies(line, config, error)
         return
      end if
      call tables%open(config%file, error)
      if (allocated(error)) return
      if (config%list) then
         call write_stdout(tables%list(), error)
      else
         call write_csv(config, tables, error)
      end if
      call tables%close()
   end subroutine export

   !> Take what the user asks for.
   subroutine configure(line, config, error)
      type(command_line_type), intent(in) :: line
      type(export_config_type), intent(out) :: config
      !> Set when that is no format, or none at all.
      type(error_type), allocatable, intent(out) :: error
      integer :: dot, format, i

      config%file = line%text("FILE.h5")
      config%output = line%text("--output")
      config%list = line%has("--list")
      config%force = line%has("--force")
      call split_at_commas(line%texts("--columns"), config%columns)
      config%format = line%text("--to")
      if (config%format == "" .and. line%has("--csv")) config%format = "csv"
      if (config%format == "" .and. line%has("--video")) config%format = "video"
      if (config%format == "") then
         ! The name of the file tells it, if it can.
         dot = index(config%output, ".", back=.true.)
         format = 0
         if (dot > 0) format = findloc(endings == config%output(dot + 1:), .true., dim=1)
         if (format > 0) config%format = trim(formats(format))
      end if
      if (line%has("--columns") .and. size(config%columns) == 0) then
         call fatal(error, "--columns needs names of columns", status_usage)
         return
      end if
      if (config%list) return
      if (config%format == "") then
         call fatal(error, "export needs a format: --to " // &
            join(strings(formats), ", --to "), status_usage)
      else if (all(formats /= config%format)) then
         call fatal(error, "unknown format " // quote(config%format) // &
            did_you_mean(config%format, formats, "expected " // join(strings(formats), " or ")), &
            status_usage)
      else if (line%has("--csv") .and. config%format /= "csv") then
         call fatal(error, "--csv and --to " // config%format // " are two formats", status_usage)
      else if (line%has("--video") .and. config%format /= "video") then
         call fatal(error, "--video and --to " // config%format // " are two formats", status_usage)
      else if (config%format /= "csv" .and. line%has("--columns")) then
         call fatal(error, "--columns is for csv; " // config%format // " has the bodies", &
            status_usage)
      end if
      do i = 1, size(options_of_bodies)
         if (allocated(error)) exit
         associate (name => options_of_bodies(i))
            if (.not. line%has(trim(name))) cycle
            if (config%format == "csv" .or. (any(options_of_films == name) .neqv. &
               (config%format == "video")) .and. i > 2) call fatal(error, trim(name) // &
               " is not for " // config%format, status_usage)
         end associate
      end do
   end subroutine configure

   !> The words between commas, without blanks around them.
   subroutine split_at_commas(texts, words)
      type(string_type), intent(in) :: texts(:)
      type(string_type), allocatable, intent(out) :: words(:)
      character(len=:), allocatable :: rest
      integer :: comma, i, n

      n = 0
      do i = 1, size(texts)
         n = n + count(transfer(texts(i)%s, ["a"]) == ",") + 1
      end do
      allocate(words(n))
      n = 0
      do i = 1, size(texts)
         rest = texts(i)%s // ","
         do while (rest /= "")
            comma = index(rest, ",")
            if (rest(:comma - 1) /= "") then
               n = n + 1
               words(n)%s = trim(adjustl(rest(:comma - 1)))
            end if
            rest = rest(comma + 1:)
         end do
      end do
      words = words(:n)
   end subroutine split_at_commas

   !> Write the bodies of a run and their motion: another program does.
   subroutine write_bodies(line, config, error)
      type(command_line_type), intent(in) :: line
      type(export_config_type), intent(in) :: config
      !> Set when that is not found.
      type(error_type), allocatable, intent(out) :: error
      type(string_type) :: words(6 + 2*size(options_of_bodies))
      character(len=:), allocatable :: name, tool, trouble
      integer :: i, n

      n = 0
      if (config%format == "video") then
         tool = "contensou-video"
      else
         tool = "contensou-export"
         call put("--to=" // config%format)
      end if
      if (config%output /= "") call put("--output=" // config%output)
      if (config%force) call put("--force")
      do i = 1, size(options_of_bodies)
         name = trim(options_of_bodies(i))
         if (.not. line%has(name)) cycle
         if (name == "--all") then
            call put(name)
         else
            call put(name // "=" // line%text(name))
         end if
      end do
      ! No name of a file is an option.
      call put("--")
      call put(config%file)
      call become(tool, words(:n), trouble)
      call fatal(error, "cannot start " // tool // ", which writes " // config%format // ": " // &
         trouble // "; it comes with the program, in the folder of its executable", status_file)

   contains

      !> Add a word.
      subroutine put(word)
         character(len=*), intent(in) :: word

         n = n + 1
         words(n)%s = word
      end subroutine put

   end subroutine write_bodies

   !> Write columns as comma-separated values.
   subroutine write_csv(config, tables, error)
      type(export_config_type), intent(in) :: config
      type(tables_type), intent(inout) :: tables
      type(error_type), allocatable, intent(out) :: error
      type(output_type) :: output
      type(string_type) :: inputs(1)
      character(len=:), allocatable :: text
      integer, allocatable :: chosen(:)
      integer(i8) :: first, last

      inputs(1)%s = config%file
      call tables%choose(config%columns, chosen, error)
      if (.not. allocated(error)) call tables%rows(chosen, last, error)
      if (.not. allocated(error)) call output%open(config%output, inputs, config%force, error)
      if (allocated(error)) return
      if (all(tables%status /= [character(len=8) :: "", "complete"])) call write_stderr( &
         "warning: " // config%file // " is not complete (" // tables%status // "); " // &
         counted(last, "row") // nl)
      call output%write(tables%header(chosen), error)
      first = 1
      do while (first <= last .and. .not. allocated(error))
         call tables%lines(chosen, first, last, text, error)
         if (.not. allocated(error)) call output%write(text, error)
      end do
      if (.not. allocated(error)) call output%finish(error)
      call output%abandon()
   end subroutine write_csv

end module contensou_drivers_export
