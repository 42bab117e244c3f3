!> What an earlier run left of an output file, and whether it can be gone on with.
!>
!> A run writes its rows to NAME.part and, after each flush, what it needs to go on to
!> NAME.part.checkpoint. Going on, the rows up to the checkpoint are copied to a new NAME.part, and
!> NAME.part.old is kept until they are there: no moment of a kill leaves less than there was.
module contensou_files_earlier
   use contensou_base_build, only : git_commit, program_version
   use contensou_base_errors, only : error_type, fatal, status_failed, status_file
   use contensou_base_guard, only : finish_guard, start_guard, wait_for_worker
   use contensou_base_kinds, only : i8, wp
   use contensou_base_operating_system, only : check_writable, checksum, file_exists, &
      first_bytes, is_locked, lock_suffix, remove_dead_lock, remove_file, rename_file, &
      unfinished_suffix, write_stderr
   use contensou_base_output_path, only : what_helps_replacing => what_helps
   use contensou_base_text, only : quote, starts_with
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_files_hdf5_reader, only : guarded_status, hdf5_reader_type, readable_status
   use contensou_files_trajectory, only : check_rows, filetype, part_suffix
   implicit none(type, external)
   private

   public :: earlier_type, check_output, find_earlier, settings_difference, put_aside, forget, &
      discard_unreadable, exchange_program, checkpoint_suffix, companions, settings_item

   !> Suffix of the file from which a run goes on.
   character(len=*), parameter :: checkpoint_suffix = part_suffix // ".checkpoint"

   !> Name of the checksum of all settings in a checkpoint.
   character(len=*), parameter :: settings_item = "settings_sum"

   !> Suffix of an earlier life's file while its rows are copied.
   character(len=*), parameter :: old_suffix = part_suffix // ".old"

   !> What the names of the files beside an output file have in addition.
   character(len=*), parameter :: companions(*) = [character(len=24) :: part_suffix, old_suffix, &
      checkpoint_suffix, checkpoint_suffix // unfinished_suffix, lock_suffix]

   !> What an earlier life left.
   type :: earlier_type
      !> Whether the run is complete, with nothing left to do.
      logical :: complete = .false.
      !> Whether there is something to continue.
      logical :: resumable = .false.
      !> File with its rows.
      character(len=:), allocatable :: source
      !> From where it goes on.
      type(checkpoint_type) :: checkpoint
      !> What there is to tell the user, in lines; empty for nothing.
      character(len=:), allocatable :: notice
      !> The same, for those who want no notices, too.
      character(len=:), allocatable :: warning
   end type earlier_type

   !> First bytes of a file in which a sweep keeps its rows, as in src/sweep/journal.c.
   character(len=*), parameter :: journal_mark = "CONTJRN1"

   !> Memory for looking at a file [bytes].
   real(wp), parameter :: memory_limit = 1.0737e9_wp

   !> What helps where an earlier run cannot be continued.
   character(len=*), parameter :: what_helps = new_line("a") // &
      "it cannot be resumed; --force begins from the start, -o FILE writes another file"

   !> The file is what is expected.
   integer, parameter :: found_good = 0

   !> It is damaged, or not the one the checkpoint speaks of.
   integer, parameter :: found_damaged = 3

   !> It is that of another scene.
   integer, parameter :: found_other = 4

   !> Its run failed, or is not complete.
   integer, parameter :: found_status = 5

contains

   !> Whether an earlier life left something from which to go on.
   function is_resumable(name) result(answer)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      logical :: answer

      answer = file_exists(name // checkpoint_suffix)
      if (answer) answer = file_exists(name // part_suffix) .or. file_exists(name // old_suffix)
   end function is_resumable

   !> What became of a run, in words: it "was killed", it "failed".
   pure function fate(status) result(words)
      !> Status of its file.
      character(len=*), intent(in) :: status
      character(len=:), allocatable :: words

      words = status
      if (status == "complete") words = "is complete"
      if (status /= "failed" .and. status /= "complete") words = "was " // status
   end function fate

   !> See that the output file can be written and that nothing is lost by it.
   subroutine check_output(name, force, resume, notice, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> Whether it may replace an existing one.
      logical, intent(in) :: force
      !> Whether an earlier run is continued, whatever there is of it.
      logical, intent(in) :: resume
      !> What there is to tell the user, a line; empty for nothing.
      character(len=:), allocatable, intent(out) :: notice
      !> Set when the run must not begin.
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: unreadable
      character(len=:), allocatable :: part, status
      logical :: is

      notice = ""
      part = name // part_suffix
      is = file_exists(name)
      if (is .and. resume) return
      if (is .and. .not. force) then
         call fatal(error, name // " exists" // what_helps_replacing(name), status_file)
         return
      end if
      call check_writable(name, "output file", error)
      if (allocated(error)) return
      if (.not. file_exists(part)) part = name // old_suffix
      if (.not. file_exists(part)) return
      if (is_locked(part)) then
         call fatal(error, "another run is writing " // part, status_file)
         return
      end if
      if (force) return
      if (first_bytes(part, len(journal_mark)) == journal_mark) then
         call fatal(error, part // " holds the rows of a sweep" // what_helps_replacing(part), &
            status_file)
         return
      end if
      if (resume) return
      call guarded_status(part, status, unreadable)
      if (allocated(unreadable)) status = ""
      is = is_resumable(name)
      if (is .and. status /= "failed") then
         if (status /= "interrupted") status = "killed"
         call fatal(error, part // " holds the rows of a run that " // fate(status) // &
            "; --resume continues it, --force replaces it, -o FILE writes another one", status_file)
      else if (status == "interrupted" .or. status == "failed") then
         call fatal(error, part // " holds the rows of a run that " // fate(status) // &
            "; --force replaces it, -o FILE writes another one", status_file)
      else
         notice = "replacing " // part // ", left by a run that was killed" // new_line("a")
      end if
   end subroutine check_output

   !> See what an earlier life left.
   subroutine find_earlier(name, resolved, earlier, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> All settings of the run.
      character(len=*), intent(in) :: resolved
      type(earlier_type), intent(out) :: earlier
      !> Set when the run must not begin.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: message
      character(len=64) :: commit
      type(error_type), allocatable :: unremoved
      integer :: found

      earlier%notice = ""
      earlier%warning = ""
      if (file_exists(name)) then
         call look_into(name, "complete", resolved, earlier%checkpoint, .false., found, message, &
            error)
         if (allocated(error)) return
         if (found == found_good) then
            earlier%complete = .true.
            if (is_resumable(name)) then
               call notice(earlier, name // " is complete; to go on with the run of " // name // &
                  part_suffix // ", move it away")
            else
               call notice(earlier, name // " is complete")
            end if
            ! A life that was killed after its last row can have left these.
            if (.not. file_exists(name // part_suffix)) then
               call forget(name, .true., unremoved)
               call remove_dead_lock(name)
            end if
         else
            call fatal(error, message // new_line("a") // &
               "--force replaces it, -o FILE writes another one", status_file)
         end if
         return
      end if
      if (is_locked(name // part_suffix)) then
         call fatal(error, "another run is writing " // name // part_suffix, status_file)
         return
      end if
      ! The older of two files is there only while its rows are being copied to the other.
      earlier%source = name // old_suffix
      if (.not. file_exists(earlier%source)) then
         earlier%source = name // part_suffix
         if (.not. file_exists(earlier%source)) then
            call notice(earlier, "there is nothing to resume; beginning from the start")
            return
         end if
      end if
      if (.not. file_exists(name // checkpoint_suffix)) then
         call without_checkpoint(name, earlier, error)
         return
      end if
      call load_checkpoint(name // checkpoint_suffix, earlier, commit, error)
      if (allocated(error)) then
         error%message = error%message // what_helps
         return
      end if
      if (commit /= git_commit()) call notice(earlier, &
         "resuming a run of another build, " // trim(commit))
      call look_into(earlier%source, "", resolved, earlier%checkpoint, .true., found, message, &
         error)
      if (allocated(error)) return
      select case (found)
      case (found_good)
         earlier%resumable = .true.
      case (found_damaged)
         ! Nothing can be lost by that; said even to those who want no notices.
         earlier%warning = message // new_line("a") // &
            "it was damaged when its run was killed; beginning from the start" // new_line("a")
      case default
         call fatal(error, message // what_helps, status_file)
      end select
   end subroutine find_earlier

   !> Tell the user.
   subroutine notice(earlier, text)
      type(earlier_type), intent(inout) :: earlier
      !> What there is to say.
      character(len=*), intent(in) :: text

      earlier%notice = earlier%notice // text // new_line("a")
   end subroutine notice

   !> There are rows, but no checkpoint.
   subroutine without_checkpoint(name, earlier, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      type(earlier_type), intent(inout) :: earlier
      !> Set when the run must not begin.
      type(error_type), allocatable, intent(inout) :: error
      character(len=:), allocatable :: status
      type(error_type), allocatable :: unreadable

      call guarded_status(earlier%source, status, unreadable)
      if (allocated(unreadable)) status = "running"
      if (status == "running") then
         call notice(earlier, earlier%source // " was left by a run that was killed before " // &
            "its first checkpoint; beginning from the start")
      else
         call fatal(error, earlier%source // " holds the rows of a run that " // &
            fate(status) // ", without " // name // checkpoint_suffix // what_helps, &
            merge(status_failed, status_file, status == "failed"))
      end if
   end subroutine without_checkpoint

   !> Load the checkpoint of an earlier run, of this version.
   subroutine load_checkpoint(path, earlier, commit, error)
      character(len=*), intent(in) :: path
      type(earlier_type), intent(inout) :: earlier
      !> Commit of the program that wrote it.
      character(len=*), intent(out) :: commit
      type(error_type), allocatable, intent(out) :: error
      character(len=64) :: version

      call earlier%checkpoint%load(path, error)
      call exchange_program(earlier%checkpoint, version, commit)
      if (.not. allocated(error)) call earlier%checkpoint%result(error)
      if (allocated(error)) return
      if (version /= program_version) call fatal(error, earlier%source // &
         " was written by version " // trim(version) // ", this is " // program_version, &
         status_file)
   end subroutine load_checkpoint

   !> See whether a file belongs to this scene and holds what it should, in a process of its own:
   !> the HDF5 library may crash over a file whose writer was killed.
   subroutine look_into(path, expected, resolved, checkpoint, has_rows, found, message, error)
      character(len=*), intent(in) :: path
      !> Status that it should have; blank for any but `failed`.
      character(len=*), intent(in) :: expected
      !> All settings of the run.
      character(len=*), intent(in) :: resolved
      type(checkpoint_type), intent(inout) :: checkpoint
      !> Whether to compare its rows with the checkpoint.
      logical, intent(in) :: has_rows
      !> One of the `found_*` codes.
      integer, intent(out) :: found
      character(len=:), allocatable, intent(out) :: message
      !> Set when there is no way to tell.
      type(error_type), allocatable, intent(out) :: error
      character(len=:), allocatable :: place, reason
      logical :: is_worker, finished, inside

      found = found_good
      call start_guard(memory_limit, is_worker, error)
      if (allocated(error)) return
      if (is_worker) then
         call judge(path, expected, resolved, checkpoint, has_rows, found, message)
         call write_stderr(message)
         call finish_guard(found)
      end if
      call wait_for_worker(finished, found, inside, place, reason, message)
      if (finished) return
      found = found_damaged
      message = "cannot read " // path // " (" // reason // ")"
   end subroutine look_into

   !> The work of `look_into`.
   subroutine judge(path, expected, resolved, checkpoint, has_rows, found, message)
      character(len=*), intent(in) :: path
      !> Status that it should have; blank for any but `failed`.
      character(len=*), intent(in) :: expected
      !> All settings of the run.
      character(len=*), intent(in) :: resolved
      type(checkpoint_type), intent(inout) :: checkpoint
      !> Whether to compare its rows with the checkpoint.
      logical, intent(in) :: has_rows
      !> One of the `found_*` codes.
      integer, intent(out) :: found
      character(len=:), allocatable, intent(out) :: message
      type(hdf5_reader_type) :: reader
      type(error_type), allocatable :: error
      character(len=:), allocatable :: kind, status, stored
      integer(i8) :: sum

      found = found_damaged
      message = ""
      call readable_status(path, status, error)
      if (.not. allocated(error)) call reader%open(path, error)
      if (.not. allocated(error)) call reader%read_text("/", "filetype", kind, error)
      if (.not. allocated(error)) call reader%read_text("/input/resolved", "", stored, error)
      call reader%close()
      if (.not. allocated(error) .and. has_rows) then
         if (checkpoint%holds(settings_item)) then
            call checkpoint%exchange(settings_item, sum)
            if (sum /= checksum(0_i8, stored)) call fatal(error, "cannot read " // path // &
               ": it is damaged, its settings are not those of its checkpoint", status_file)
         end if
      end if
      if (.not. allocated(error)) then
         if (kind /= filetype) then
            message = path // " is not the output of a run"
            found = found_status
            return
         end if
         message = settings_difference(stored, resolved)
         if (message /= "") then
            message = path // " is of another scene: " // message
            found = found_other
            return
         end if
         if (status == "failed" .or. (expected /= "" .and. status /= expected)) then
            message = path // " holds a run with status " // quote(status)
            found = found_status
            return
         end if
         if (has_rows) call check_rows(path, checkpoint, error)
      end if
      if (allocated(error)) then
         message = error%message
      else
         found = found_good
      end if
   end subroutine judge

   !> The first difference of two sets of settings in words, the name of the output file aside;
   !> blank if there is none.
   function settings_difference(before, now) result(words)
      !> Settings of the earlier run.
      character(len=*), intent(in) :: before
      !> Settings of this one.
      character(len=*), intent(in) :: now
      character(len=:), allocatable :: words
      character(len=*), parameter :: name_key = "name = "
      character(len=:), allocatable :: line, other, group, name
      integer :: at, at_other, equals
      logical :: same_key

      words = ""
      group = ""
      name = ""
      at = 1
      at_other = 1
      do while (at <= len(before) .or. at_other <= len(now))
         line = next_line(before, at)
         other = next_line(now, at_other)
         if (line == other) then
            if (starts_with(line, "&")) then
               group = line(2:)
               name = ""
            else if (starts_with(line, name_key)) then
               name = line(len(name_key) + 1:)
            end if
            cycle
         end if
         if (group == "output" .and. starts_with(line, "file = ") .and. &
            starts_with(other, "file = ")) cycle
         equals = index(line, " = ")
         same_key = .false.
         if (equals > 0) same_key = starts_with(other, line(:equals + 2))
         if (same_key) then
            words = group // "." // line(:equals - 1) // " is " // line(equals + 3:) // &
               " in it and " // other(equals + 3:) // " here"
         else
            words = group // " has " // quote(line) // " in it and " // quote(other) // " here"
         end if
         if (name /= "") words = words // ", in " // group // " " // name
         return
      end do
   end function settings_difference

   !> The next line of a text, without leading blanks; empty after the end.
   function next_line(text, at) result(line)
      character(len=*), intent(in) :: text
      !> Where it begins, moved to the line after it.
      integer, intent(inout) :: at
      character(len=:), allocatable :: line
      integer :: length

      line = ""
      if (at > len(text)) return
      length = index(text(at:), new_line("a")) - 1
      if (length < 0) length = len(text) - at + 1
      line = trim(adjustl(text(at:at + length - 1)))
      at = at + length + 1
   end function next_line

   !> Put the file of an earlier life aside, so that a new one can take its rows.
   subroutine put_aside(name, earlier, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> The earlier life; its file gets another name.
      type(earlier_type), intent(inout) :: earlier
      !> Set when that failed, as when another run does the same.
      type(error_type), allocatable, intent(out) :: error

      if (earlier%source == name // old_suffix) return
      call rename_file(earlier%source, name // old_suffix, error, replace=.false.)
      if (.not. allocated(error)) earlier%source = name // old_suffix
   end subroutine put_aside

   !> Remove what an earlier life left, apart from its rows under the name of this one.
   subroutine forget(name, and_checkpoint, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> Whether the checkpoint goes, too.
      logical, intent(in) :: and_checkpoint
      !> Set when something is still there.
      type(error_type), allocatable, intent(out) :: error

      if (and_checkpoint) call remove_file(name // checkpoint_suffix, error)
      ! One that was being written when its run was killed.
      if (.not. allocated(error) .and. and_checkpoint) call remove_file(name // &
         checkpoint_suffix // unfinished_suffix, error)
      if (.not. allocated(error)) call remove_file(name // old_suffix, error)
   end subroutine forget

   !> After a failure to write: keep the partial file if its rows can be read, otherwise remove it.
   subroutine discard_unreadable(name, error)
      !> Name of the output file.
      character(len=*), intent(in) :: name
      !> The failure; its message is completed.
      type(error_type), allocatable, intent(inout) :: error
      type(error_type), allocatable :: unreadable
      character(len=:), allocatable :: status

      if (.not. file_exists(name // part_suffix)) return
      call guarded_status(name // part_suffix, status, unreadable)
      if (.not. allocated(unreadable)) then
         error%message = error%message // new_line("a") // "the rows written before are in " // &
            name // part_suffix
      else
         call remove_file(name // part_suffix, unreadable)
      end if
   end subroutine discard_unreadable

   !> Write the program to a checkpoint, or read which one wrote it.
   subroutine exchange_program(checkpoint, version, commit)
      type(checkpoint_type), intent(inout) :: checkpoint
      !> Version of the program.
      character(len=*), intent(inout) :: version
      character(len=*), intent(inout) :: commit

      call checkpoint%exchange("program_version", version)
      call checkpoint%exchange("git_commit", commit)
   end subroutine exchange_program

end module contensou_files_earlier
