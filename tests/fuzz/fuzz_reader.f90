!> Feeds mutated scenes to the scene reader.
program fuzz_reader
   use fuzz_reader_run, only : run
   implicit none(type, external)
   integer :: status

   call run(status)
   stop status, quiet=.true.
end program fuzz_reader
