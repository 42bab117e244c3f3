!> Command line of the executable: from words to one plain configuration per sub-command.
module contensou_drivers_command_line
   use, intrinsic :: ieee_arithmetic, only : ieee_is_finite
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_kinds, only : wp
   use contensou_base_text, only : nearest, quote, read_real, starts_with, string_type
   use contensou_compare_rules, only : built_in_text, whole_run_text
   implicit none(type, external)
   private

   public :: command_type, parse_command_line, command_line_words, command_text, usage_text, &
      commands

   !> What the user asks for; a sub-command uses the fields that its usage names.
   type :: command_type
      !> Sub-command: run, check, models, eval, bench, cost, diff, sweep, merge, help, version.
      character(len=:), allocatable :: name
      !> Scene (run, check), model (models), kernel (eval), what to measure (bench), first file
      !> (diff, merge), sweep (sweep) or topic (help); may be blank.
      character(len=:), allocatable :: subject
      !> Texts of the `--set` options.
      type(string_type), allocatable :: overrides(:)
      !> Output file (run); blank for that of the scene. Output files without ending (bench).
      character(len=:), allocatable :: output
      !> Whether to replace existing output files.
      logical :: force = .false.
      !> Whether to print the scene with all settings and patterns expanded, no more (check).
      logical :: expand = .false.
      !> Whether to continue an interrupted run (run).
      logical :: resume = .false.
      !> Seconds between two checkpoints (run) [s].
      real(wp) :: checkpoint = 5.0_wp
      !> Whether to measure for a short time only (bench).
      logical :: quick = .false.
      !> Whether the wrench comes with its derivatives (eval).
      logical :: jacobian = .false.
      !> Whether to be silent on stderr unless something is wrong.
      logical :: quiet = .false.
      !> Model of a kernel (eval); blank for the default.
      character(len=:), allocatable :: model
      !> Input file (eval); blank for the standard input. Second file (diff).
      character(len=:), allocatable :: input
      !> Regularisation velocity (eval wrench) [m/s].
      real(wp) :: delta = 0.0_wp
      !> File of rules (diff); blank for none.
      character(len=:), allocatable :: rules
      !> Whether only a part of the run is compared (diff).
      logical :: has_until = .false.
      !> End of that part (diff) [s].
      real(wp) :: until = 0.0_wp
      !> CSV file (cost); blank for none.
      character(len=:), allocatable :: csv
      !> Whether the cheapest choice for an error is asked for (cost).
      logical :: has_error = .false.
      !> That error, scaled (cost) [-].
      real(wp) :: largest_error = 0.0_wp
      !> Whether the CPU time is told by effect (run).
      logical :: profile = .false.
      !> Number of threads (sweep); 0 for as many as there are cores.
      integer :: jobs = 0
      !> Which part of the cases is done (sweep), and of how many; 0 for all.
      integer :: shard = 0, shards = 0
      !> Ranges of cases that are done (sweep), such as "1:500,800"; blank for all.
      character(len=:), allocatable :: cases
      !> Files that are joined (merge).
      type(string_type), allocatable :: files(:)
      !> Whether cases may be missing (merge).
      logical :: partial = .false.
   end type command_type

   !> Sub-commands.
   character(len=*), parameter :: commands(*) = [character(len=8) :: &
      "run", "check", "models", "eval", "bench", "cost", "diff", "sweep", "merge", "help", &
      "version"]

   !> What a sub-command needs.
   type :: operand_type
      !> Sub-command.
      character(len=8) :: command
      !> Its first operand, in words.
      character(len=12) :: operand
   end type operand_type

   !> Sub-commands that need an operand.
   type(operand_type), parameter :: operands(*) = [operand_type("run", "scene"), &
      operand_type("check", "scene"), operand_type("eval", "kernel"), &
      operand_type("bench", "benchmark"), operand_type("cost", "scene"), &
      operand_type("diff", "file"), operand_type("sweep", "sweep file"), &
      operand_type("merge", "file")]

contains

   !> The words of the command line after the program's name.
   function command_line_words() result(words)
      type(string_type), allocatable :: words(:)
      integer :: i, length

      allocate(words(command_argument_count()))
      do i = 1, size(words)
         call get_command_argument(i, length=length)
         allocate(character(len=length) :: words(i)%s)
         call get_command_argument(i, words(i)%s)
      end do
   end function command_line_words

   !> Understand the command line.
   subroutine parse_command_line(words, command, error)
      !> Words after the program's name.
      type(string_type), intent(in) :: words(:)
      !> What the user asks for.
      type(command_type), intent(out) :: command
      !> Set when it cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      integer :: i, first

      command%name = ""
      command%subject = ""
      command%output = ""
      command%model = ""
      command%input = ""
      command%rules = ""
      command%csv = ""
      command%cases = ""
      allocate(command%overrides(0), command%files(0))
      if (size(words) == 0) then
         call fatal(error, "no command is given" // new_line("a") // usage_text(""), status_usage)
         return
      end if
      first = 2
      select case (words(1)%s)
      case ("--version", "-V")
         command%name = "version"
      case ("--help", "-h")
         command%name = "usage"
         return
      case default
         command%name = words(1)%s
         if (.not. any(commands == command%name)) then
            i = nearest(command%name, commands)
            if (i > 0) then
               call fatal(error, "unknown command " // quote(command%name) // "; did you mean " // &
                  quote(trim(commands(i))) // "?", status_usage)
            else
               call fatal(error, "unknown command " // quote(command%name) // new_line("a") // &
                  usage_text(""), status_usage)
            end if
            return
         end if
      end select
      do i = first, size(words)
         if (words(i)%s == "--help" .or. words(i)%s == "-h") then
            command%subject = command%name
            command%name = "usage"
            return
         end if
      end do
      call parse_options(words, first, command, error)
      if (allocated(error)) return
      if (command%subject == "" .and. any(command%name == operands%command)) then
         i = findloc(operands%command == command%name, .true., dim=1)
         call fatal(error, command%name // " needs a " // trim(operands(i)%operand) // &
            new_line("a") // usage_text(command%name), status_usage)
      else if (command%name == "diff" .and. command%input == "") then
         call fatal(error, "diff needs two files" // new_line("a") // usage_text("diff"), &
            status_usage)
      else if (command%resume .and. command%force) then
         call fatal(error, "--resume continues what there is, --force replaces it: only one " // &
            "of them can be meant", status_usage)
      end if
   end subroutine parse_command_line

   !> Options and operands of a sub-command.
   subroutine parse_options(words, first, command, error)
      !> Words of the command line.
      type(string_type), intent(in) :: words(:)
      !> First one to look at.
      integer, intent(in) :: first
      !> What the user asks for.
      type(command_type), intent(inout) :: command
      !> Set when it cannot be understood.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: word, value
      logical :: valid, only_operands
      integer :: i, n_operands

      i = first
      n_operands = 0
      only_operands = .false.
      do while (i <= size(words))
         word = words(i)%s
         value = ""
         if (only_operands .or. .not. starts_with(word, "-") .or. word == "-") then
            call operand()
         else if (word == "--") then
            only_operands = .true.
         else
            select case (option_of(word))
            case ("--set")
               call take_value()
               if (.not. allocated(error)) call append(command%overrides, value)
            case ("-o", "--output")
               call take_value()
               command%output = value
               if (.not. allocated(error) .and. value == "") call fatal(error, &
                  "-o needs the name of a file", status_usage)
            case ("--model")
               call take_value()
               command%model = value
            case ("--delta")
               call take_value()
               if (.not. allocated(error)) then
                  call read_real(value, command%delta, valid)
                  if (valid) valid = ieee_is_finite(command%delta)
                  if (valid) valid = command%delta >= 0.0_wp
                  if (.not. valid) call fatal(error, "--delta needs a velocity " // &
                     ">= 0 [m/s], not " // quote(value), status_usage)
               end if
            case ("--csv")
               call take_value()
               command%csv = value
               if (.not. allocated(error) .and. value == "") call fatal(error, &
                  "--csv needs the name of a file", status_usage)
            case ("--error")
               call take_value()
               if (.not. allocated(error)) then
                  command%has_error = .true.
                  call read_real(value, command%largest_error, valid)
                  if (valid) valid = ieee_is_finite(command%largest_error)
                  if (valid) valid = command%largest_error > 0.0_wp
                  if (.not. valid) call fatal(error, "--error needs a number > 0 [-], not " // &
                     quote(value), status_usage)
               end if
            case ("--profile")
               command%profile = .true.
            case ("-j", "--jobs")
               call take_value()
               if (.not. allocated(error)) call read_jobs()
            case ("--shard")
               call take_value()
               if (.not. allocated(error)) call read_shard()
            case ("--cases")
               call take_value()
               command%cases = value
               if (.not. allocated(error) .and. value == "") call fatal(error, &
                  "--cases needs ranges such as 1:500,800", status_usage)
            case ("--partial")
               command%partial = .true.
            case ("--rules")
               call take_value()
               command%rules = value
               if (.not. allocated(error) .and. value == "") call fatal(error, &
                  "--rules needs the name of a file", status_usage)
            case ("--until")
               call take_value()
               if (.not. allocated(error)) then
                  command%has_until = .true.
                  call read_real(value, command%until, valid)
                  if (valid) valid = ieee_is_finite(command%until)
                  if (.not. valid) call fatal(error, "--until needs a time [s], not " // &
                     quote(value), status_usage)
               end if
            case ("--force")
               command%force = .true.
            case ("--resume")
               command%resume = .true.
            case ("--checkpoint")
               call take_value()
               if (.not. allocated(error)) then
                  call read_real(value, command%checkpoint, valid)
                  if (valid) valid = ieee_is_finite(command%checkpoint)
                  if (valid) valid = command%checkpoint >= 0.0_wp
                  if (.not. valid) call fatal(error, "--checkpoint needs a time >= 0 [s], not " // &
                     quote(value), status_usage)
               end if
            case ("-q", "--quiet")
               command%quiet = .true.
            case ("--quick")
               command%quick = .true.
            case ("--expand")
               command%expand = .true.
            case ("--jacobian")
               command%jacobian = .true.
            case default
               call unknown()
            end select
         end if
         if (allocated(error)) return
         i = i + 1
      end do

   contains

      !> Take an operand.
      subroutine operand()
         n_operands = n_operands + 1
         if (command%name == "merge") call append(command%files, word)
         if (n_operands == 1 .and. command%name /= "version") then
            command%subject = word
         else if (n_operands == 2 .and. any(command%name == ["eval", "diff"])) then
            command%input = word
         else if (command%name /= "merge") then
            call fatal(error, "unexpected word " // quote(word) // new_line("a") // &
               usage_text(command%name), status_usage)
         end if
      end subroutine operand

      !> The option of a word, if this sub-command has it.
      function option_of(word) result(option)
         character(len=*), intent(in) :: word
         character(len=:), allocatable :: option
         integer :: equals

         equals = index(word, "=")
         option = word
         if (starts_with(word, "--") .and. equals > 0) option = word(:equals - 1)
         if (starts_with(word, "-j") .and. len(word) > 2) option = "-j"
         select case (option)
         case ("--set")
            if (all(command%name /= ["run  ", "check", "cost ", "sweep", "merge"])) option = ""
         case ("-o", "--output", "--force")
            if (all(command%name /= ["run  ", "bench", "cost ", "sweep", "merge"])) option = ""
         case ("-q", "--quiet")
            if (all(command%name /= ["run  ", "diff ", "cost ", "sweep", "merge"])) option = ""
         case ("--csv", "--error")
            if (command%name /= "cost") option = ""
         case ("--profile")
            if (command%name /= "run") option = ""
         case ("-j", "--jobs", "--shard", "--cases")
            if (command%name /= "sweep") option = ""
         case ("--partial")
            if (command%name /= "merge") option = ""
         case ("--rules", "--until")
            if (command%name /= "diff") option = ""
         case ("--resume", "--checkpoint")
            if (command%name /= "run") option = ""
         case ("--quick")
            if (command%name /= "bench") option = ""
         case ("--expand")
            if (command%name /= "check") option = ""
         case ("--model", "--delta", "--jacobian")
            if (command%name /= "eval") option = ""
         case default
            option = ""
         end select
         ! Flags take no value.
         if (any(option == ["--force   ", "--quiet   ", "--quick   ", &
            "--jacobian", "--expand  ", "--profile ", "--resume  ", "--partial "]) .and. &
            equals > 0) option = ""
      end function option_of

      !> The value of an option: after '=', or the next word.
      subroutine take_value()
         integer :: equals

         equals = index(word, "=")
         if (starts_with(word, "--") .and. equals > 0) then
            value = word(equals + 1:)
         else if (starts_with(word, "-j") .and. len(word) > 2) then
            value = word(3:)
         else if (i < size(words)) then
            i = i + 1
            value = words(i)%s
         else
            call fatal(error, word // " needs a value" // new_line("a") // &
               usage_text(command%name), status_usage)
         end if
      end subroutine take_value

      !> The number of threads.
      subroutine read_jobs()
         integer :: io

         io = 1
         if (verify(value, "0123456789") == 0 .and. len(value) <= 6) read(value, *, iostat=io) &
            command%jobs
         if (io /= 0 .or. command%jobs < 1) call fatal(error, &
            "-j needs a number of threads >= 1, not " // quote(value), status_usage)
      end subroutine read_jobs

      !> Which shard of how many.
      subroutine read_shard()
         integer :: slash, io
         logical :: valid

         slash = index(value, "/")
         valid = slash > 1 .and. slash < len(value) .and. slash <= 9 .and. len(value) - slash <= 8
         if (valid) valid = verify(value(:slash - 1), "0123456789") == 0 .and. &
            verify(value(slash + 1:), "0123456789") == 0
         if (valid) then
            read(value(:slash - 1), *, iostat=io) command%shard
            valid = io == 0
            read(value(slash + 1:), *, iostat=io) command%shards
            valid = valid .and. io == 0
         end if
         if (valid) valid = command%shard >= 1 .and. command%shard <= command%shards
         if (.not. valid) call fatal(error, "--shard needs K/M with 1 <= K <= M, not " // &
            quote(value), status_usage)
      end subroutine read_shard

      !> Report an unknown option.
      subroutine unknown()
         character(len=12), parameter :: options(*) = [character(len=12) :: "--set", "--output", &
            "--force", "--quiet", "--quick", "--model", "--delta", "--jacobian", "--rules", &
            "--until", "--expand", "--csv", "--error", "--profile", "--resume", "--checkpoint", &
            "--jobs", "--shard", "--cases", "--partial"]
         integer :: near, i_option
         logical :: known(size(options))

         ! Only those that this sub-command has: --quiet and --quick are near each other.
         do i_option = 1, size(options)
            known(i_option) = option_of(trim(options(i_option))) /= ""
         end do
         near = nearest(word, merge(options, repeat(" ", len(options)), known))
         if (near > 0) then
            call fatal(error, "unknown option " // quote(word) // "; did you mean " // &
               quote(trim(options(near))) // "?", status_usage)
         else
            call fatal(error, "unknown option " // quote(word) // new_line("a") // &
               usage_text(command%name), status_usage)
         end if
      end subroutine unknown

   end subroutine parse_options

   !> Add a text to a list.
   subroutine append(list, text)
      type(string_type), allocatable, intent(inout) :: list(:)
      character(len=*), intent(in) :: text
      type(string_type), allocatable :: longer(:)
      integer :: i

      allocate(longer(size(list) + 1))
      do i = 1, size(list)
         longer(i)%s = list(i)%s
      end do
      longer(i)%s = text
      call move_alloc(longer, list)
   end subroutine append

   !> Usage of a sub-command, or of the program.
   pure function usage_text(command) result(text)
      !> Sub-command; blank for the program.
      character(len=*), intent(in) :: command
      character(len=:), allocatable :: text
      character(len=*), parameter :: nl = new_line("a")

      select case (command)
      case ("run")
         text = "usage: contensou run SCENE [--set PATH=VALUE]... [-o FILE] " // &
            "[--force | --resume] [--checkpoint S] [-q]" // nl // &
            "  SCENE            namelist file" // nl // &
            "  --set PATH=VALUE replace a value: PATH is group.key, name.key or group.name.key" // &
            nl // "  -o FILE          output file, instead of that of the scene" // nl // &
            "  --force          replace an existing output file" // nl // &
            "  --resume         continue an interrupted or killed run; begin it if there is " // &
            "none," // nl // "                   do nothing if it is complete" // nl // &
            "  --checkpoint S   wall time between two checkpoints [s], default 5" // nl // &
            "  -q               no progress on stderr" // nl // &
            "  --profile        tell the CPU time by effect"
      case ("cost")
         text = "usage: contensou cost SCENE [--error E] [-o FILE] [--csv FILE] [--force] " // &
            "[-q] [--set PATH=VALUE]..." // nl // &
            "  runs the scene over models, methods and tolerances, those of its group &cost," // &
            nl // "  and reports errors against CPU time" // nl // &
            "  --error E        name the cheapest choice with an error of at most E" // nl // &
            "  -o FILE          write an HDF5 file, for scripts/plot" // nl // &
            "  --csv FILE       write the table" // nl // &
            "  --force          replace existing files" // nl // &
            "  -q               no progress on stderr" // nl // &
            "  --set PATH=VALUE replace a value, as in run: --set cost.rtol=1e-4,1e-6"
      case ("check")
         text = "usage: contensou check SCENE [--set PATH=VALUE]... [--expand]" // nl // &
            "  reads and resolves the scene, reports its effects and their cost, " // &
            "writes nothing" // nl // &
            "  --expand         print only the scene that is run, with all settings and " // &
            "every bearing" // nl // &
            "                   expanded; it is legal and gives the same run"
      case ("models")
         text = "usage: contensou models [NAME]"
      case ("eval")
         text = "usage: contensou eval KERNEL [--model NAME] [--delta VELOCITY] [FILE]" // nl // &
            "  FILE             CSV with a header; standard input if not given" // nl // &
            "  --delta VELOCITY regularisation velocity of the wrench [m/s], default 0" // nl // &
            "  --jacobian       the wrench's derivatives, too: dFxdvx ... dTzdw" // nl // &
            "  KERNEL    inputs             outputs              models, the default first" // nl &
            // "  elliptic  c1 (or c)          K,E,B,D,dKdc,dEdc    tables, theta, agm, gsl" // nl &
            // "  hertz     A,B,Estar,delta    c,c1,a,b,N,p0        hertz (= tables), newton, " // &
            "brewe_hamrock," // nl // &
            "                                                    greenwood, vilke (= " // &
            "vilke_chord)," // nl // &
            "                                                    vilke_power, vilke_exact, " // &
            "newton_agm," // nl // &
            "                                                    newton_gsl, newton_theta" // &
            nl // "  wrench    N,a,b,f,vx,vy,w    Fx,Fy,Tz             contensou_exact, " // &
            "coulomb, pade11," // nl // &
            "                                                    pade22, contensou_simplified"
      case ("bench")
         text = "usage: contensou bench kernels [-o NAME] [--force] [--quick]" // nl // &
            "  measures error and cost of every way to compute every kernel, in 8 s" // nl // &
            "  -o NAME          write NAME.csv and NAME.h5" // nl // &
            "  --force          replace existing files" // nl // &
            "  --quick          2 s, fewer arguments: rough times"
      case ("diff")
         text = diff_usage()
      case ("sweep")
         text = "usage: contensou sweep SWEEP [-j N] [--shard K/M] [--cases A:B[,C]] " // &
            "[-o FILE] [--force] [-q]" // nl // &
            "                       [--set PATH=VALUE]..." // nl // &
            "  runs a scene over its parameters, as a sweep file says, into one table" // nl // &
            "  -j N             threads; without it OMP_NUM_THREADS, SLURM_CPUS_PER_TASK or " // &
            "all cores" // nl // &
            "  --shard K/M      only part K of M, into FILE_shard_K_of_M" // nl // &
            "  --cases A:B,C    only these cases, into FILE_cases_A_to_C" // nl // &
            "  -o FILE          table, instead of that of the sweep file" // nl // &
            "  --force          begin anew, replace existing files" // nl // &
            "  -q               no progress on stderr" // nl // &
            "  --set PATH=VALUE replace a value of the scene in all cases, as in run" // nl // &
            "  a sweep that was stopped goes on when it is started again; exit status 75 if a " // &
            "signal stopped it"
      case ("merge")
         text = "usage: contensou merge FILE... -o TABLE [--force] [--partial] [-q]" // nl // &
            "       contensou merge SWEEP [-o TABLE] [--force] [--partial] [-q] " // &
            "[--set PATH=VALUE]..." // nl // &
            "  joins the tables of shards, or all of those of a sweep file" // nl // &
            "  -o TABLE         table" // nl // &
            "  --force          replace an existing table" // nl // &
            "  --partial        also if cases are missing" // nl // &
            "  -q               no progress on stderr" // nl // &
            "  --set PATH=VALUE as it was given to sweep"
      case ("help")
         text = "usage: contensou help [GROUP[.KEY] | COMMAND]"
      case default
         text = "usage: contensou COMMAND ..." // nl // &
            "  run SCENE        simulate a scene" // nl // &
            "  check SCENE      read a scene or sweep, report its effects and their cost" // nl // &
            "  models [NAME]    the models that a scene can name" // nl // &
            "  eval KERNEL      evaluate a kernel on a table of inputs" // nl // &
            "  cost SCENE       errors and CPU times over models, methods, tolerances" // nl // &
            "  bench kernels    measure error and cost of the kernels" // nl // &
            "  diff A.h5 B.h5   compare two output files" // nl // &
            "  sweep SWEEP      run a scene over parameters, many cases at a time" // nl // &
            "  merge FILE...    join the tables of parts of a sweep" // nl // &
            "  help GROUP.KEY   what a key of a scene means" // nl // &
            "  --version        version of the program" // nl // &
            "contensou COMMAND --help tells more"
      end select
   end function usage_text

   !> Usage of `diff`.
   pure function diff_usage() result(text)
      character(len=:), allocatable :: text
      character(len=*), parameter :: nl = new_line("a")
      integer :: i

      text = "usage: contensou diff A.h5 B.h5 [--rules FILE] [--until T] [-q]" // nl // &
         "  compares all data sets and attributes, exactly unless a rule says otherwise;" // nl // &
         "  exit status 0 same, 1 different, 2 trouble" // nl // &
         "  --rules FILE     lines PATTERN ATOL RTOL or PATTERN ignore, # for comments;" // nl // &
         "                   the last that matches wins;" // nl // &
         "                   |a - b| <= ATOL + RTOL max(|a|, |b|)" // nl // &
         "  --until T        leave out rows and events after the time T [s]" // nl // &
         "  -q               no results on stdout" // nl // &
         "  built-in rules, which only a rule without * ? [ outdoes:"
      do i = 1, size(built_in_text)
         text = text // nl // "    " // trim(built_in_text(i))
      end do
      text = text // nl // "  and with --until, which none outdoes:"
      do i = 1, size(whole_run_text)
         text = text // nl // "    " // trim(whole_run_text(i))
      end do
   end function diff_usage

   !> The command line as one text.
   pure function command_text(words) result(text)
      type(string_type), intent(in) :: words(:)
      character(len=:), allocatable :: text
      integer :: i

      text = "contensou"
      do i = 1, size(words)
         if (verify(words(i)%s, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ" // &
            "0123456789-_./=,+:@%") > 0 .or. words(i)%s == "") then
            text = text // " " // quote(words(i)%s)
         else
            text = text // " " // words(i)%s
         end if
      end do
   end function command_text

end module contensou_drivers_command_line
