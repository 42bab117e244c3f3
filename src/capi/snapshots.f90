!> C interface of what is kept of a simulation; include/contensou.h documents it.
module contensou_capi_snapshots
   use, intrinsic :: iso_c_binding, only : c_associated, c_char, c_f_pointer, c_int, c_loc, &
      c_null_ptr, c_ptr, c_size_t
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_errors, only : error_type, fatal, status_usage
   use contensou_base_text_lock, only : lock_texts, unlock_texts
   use contensou_capi_handles, only : describe, handle_type, status_of, take
   use contensou_capi_table, only : address_of, drop_handle, lives, new_handle, of_simulation, &
      of_snapshot
   use contensou_capi_texts, only : c_text_type
   implicit none(type, external)
   private

   public :: contensou_simulation_save, contensou_simulation_restore, contensou_simulation_copy
   public :: contensou_snapshot_bytes, contensou_snapshot_new, contensou_snapshot_free

   !> Where a simulation was, as the bytes of a checkpoint.
   type :: snapshot_type
      type(c_text_type) :: bytes
      character(len=:), allocatable :: text
   end type snapshot_type

contains

   !> Keep where a simulation has come to; null on failure.
   function contensou_simulation_save(handle, error_out) result(snapshot) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: snapshot
      type(handle_type), pointer :: self
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error
      type(checkpoint_type) :: checkpoint
      integer(c_int) :: status

      snapshot = c_null_ptr
      call lock_texts()
      call take(handle, self, error)
      if (.not. allocated(error)) then
         call checkpoint%begin()
         call self%course%exchange(checkpoint, error)
      end if
      if (.not. allocated(error)) then
         allocate(kept)
         call checkpoint%to_memory(kept%text)
         call kept%bytes%set(kept%text)
         snapshot = new_handle(c_loc(kept), of_snapshot)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_simulation_save

   !> Bring a simulation to where one has come to.
   function contensou_simulation_restore(handle, snapshot, error_out) result(status) bind(c)
      type(c_ptr), intent(in), value :: handle
      type(c_ptr), intent(in), value :: snapshot
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      integer(c_int) :: status
      type(handle_type), pointer :: self
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error

      call lock_texts()
      call take(handle, self, error)
      if (.not. allocated(error) .and. .not. lives(snapshot, of_snapshot)) call fatal(error, &
         "there is no snapshot", status_usage)
      if (.not. allocated(error)) then
         call c_f_pointer(address_of(snapshot, of_snapshot), kept)
         call bring(self, kept, error)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_simulation_restore

   !> Bring a simulation to a snapshot; to its beginning if that fails.
   subroutine bring(self, kept, error)
      type(handle_type), intent(inout), target :: self
      type(snapshot_type), intent(in) :: kept
      type(error_type), allocatable, intent(out) :: error
      type(error_type), allocatable :: ignored
      type(checkpoint_type) :: checkpoint

      call checkpoint%from_memory("the snapshot", kept%text, error)
      if (allocated(error)) return
      call self%course%begin(self%loaded%file, error)
      if (allocated(error)) return
      self%course%guide%listener => self%caller
      call self%course%exchange(checkpoint, error)
      if (allocated(error)) call self%course%begin(self%loaded%file, ignored)
   end subroutine bring

   !> A second simulation like the first; null on failure.
   function contensou_simulation_copy(handle, error_out) result(copy) bind(c)
      type(c_ptr), intent(in), value :: handle
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: copy
      type(handle_type), pointer :: self, second
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error
      type(c_ptr) :: snapshot
      integer(c_int) :: status

      copy = c_null_ptr
      snapshot = contensou_simulation_save(handle, error_out)
      if (.not. lives(snapshot, of_snapshot)) return
      call lock_texts()
      call c_f_pointer(address_of(handle, of_simulation), self)
      call c_f_pointer(address_of(snapshot, of_snapshot), kept)
      allocate(second)
      second%name = self%name
      if (allocated(self%text)) second%text = self%text
      allocate(second%loaded, source=self%loaded)
      second%settings = self%settings
      call second%course%begin(second%loaded%file, error)
      if (.not. allocated(error)) then
         call describe(second)
         call bring(second, kept, error)
      end if
      if (allocated(error)) then
         deallocate(second)
      else
         copy = new_handle(c_loc(second), of_simulation)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
      call contensou_snapshot_free(snapshot)
   end function contensou_simulation_copy

   !> A snapshot as bytes; null for none.
   function contensou_snapshot_bytes(snapshot, size) result(bytes) bind(c)
      type(c_ptr), intent(in), value :: snapshot
      !> Where to put their number; null if it is not wanted.
      type(c_ptr), intent(in), value :: size
      type(c_ptr) :: bytes
      type(snapshot_type), pointer :: kept
      integer(c_size_t), pointer :: n

      bytes = c_null_ptr
      if (.not. lives(snapshot, of_snapshot)) return
      call c_f_pointer(address_of(snapshot, of_snapshot), kept)
      bytes = kept%bytes%address()
      if (.not. c_associated(size)) return
      call c_f_pointer(size, n)
      n = len(kept%text)
   end function contensou_snapshot_bytes

   !> A snapshot of bytes; null if they are none.
   function contensou_snapshot_new(bytes, size, error_out) result(snapshot) bind(c)
      type(c_ptr), intent(in), value :: bytes
      !> Their number.
      integer(c_size_t), intent(in), value :: size
      !> Where to put an error; null if it is not wanted.
      type(c_ptr), intent(in), value :: error_out
      type(c_ptr) :: snapshot
      type(snapshot_type), pointer :: kept
      type(error_type), allocatable :: error
      type(checkpoint_type) :: checkpoint
      character(len=1, kind=c_char), pointer :: from(:)
      integer(c_int) :: status
      integer :: i

      snapshot = c_null_ptr
      call lock_texts()
      if (.not. c_associated(bytes) .or. size >= huge(i)) then
         call fatal(error, "there is no snapshot", status_usage)
      else
         allocate(kept)
         call c_f_pointer(bytes, from, [size])
         allocate(character(len=size) :: kept%text)
         do i = 1, int(size)
            kept%text(i:i) = from(i)
         end do
         call checkpoint%from_memory("the snapshot", kept%text, error)
         call kept%bytes%set(kept%text)
         if (allocated(error)) deallocate(kept)
         if (.not. allocated(error)) snapshot = new_handle(c_loc(kept), of_snapshot)
      end if
      status = status_of(error, error_out)
      call unlock_texts()
   end function contensou_snapshot_new

   !> Release a snapshot; null is admitted.
   subroutine contensou_snapshot_free(snapshot) bind(c)
      type(c_ptr), intent(in), value :: snapshot
      type(snapshot_type), pointer :: kept

      if (.not. lives(snapshot, of_snapshot)) return
      call c_f_pointer(address_of(snapshot, of_snapshot), kept)
      call drop_handle(snapshot, of_snapshot)
      deallocate(kept)
   end subroutine contensou_snapshot_free

end module contensou_capi_snapshots
