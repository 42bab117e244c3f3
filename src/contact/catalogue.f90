!> What a user can read about a model that can be named in a scene.
!>
!> Each part of a contact keeps one table of its models. The table serves construction, the
!> "expected one of" of messages, `contensou models`, and the test that constructs each entry.
module contensou_contact_catalogue
   implicit none(type, external)
   private

   public :: model_info_type

   !> Description of a model; texts are padded with blanks.
   type :: model_info_type
      !> Name in a scene.
      character(len=24) :: name = ""
      !> One line: what it is, with its formula.
      character(len=160) :: summary = ""
      !> Keys of the group `contact` that it uses, with units, separated by commas.
      character(len=160) :: keys = ""
      !> Where the formula comes from.
      character(len=120) :: reference = ""
   end type model_info_type

end module contensou_contact_catalogue
