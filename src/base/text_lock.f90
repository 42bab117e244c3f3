!> Threads that handle texts do so one at a time.
!>
!> gfortran keeps the length of a function result of deferred length in static memory. What calls
!> such functions and may be called by several threads at once does so between `lock_texts` and
!> `unlock_texts`; these pairs nest. Reading a scene and making a simulation do; a march does not,
!> but for the text of its failure.
module contensou_base_text_lock
   implicit none(type, external)
   private

   public :: lock_texts, unlock_texts

   interface
      !> Begin to handle texts in a thread; waits until no other thread does.
      subroutine lock_texts() bind(c, name="contensou_text_lock")
         implicit none(type, external)
      end subroutine lock_texts

      !> End to handle texts in a thread.
      subroutine unlock_texts() bind(c, name="contensou_text_unlock")
         implicit none(type, external)
      end subroutine unlock_texts
   end interface

end module contensou_base_text_lock
