!> The commands of the program: a row for each.
module contensou_drivers_commands
   use contensou_drivers_bearing, only : bearing_command
   use contensou_drivers_bench, only : bench_command
   use contensou_drivers_check, only : check_command
   use contensou_drivers_command_line, only : command_type
   use contensou_drivers_cost, only : cost_command
   use contensou_drivers_diff, only : diff_command
   use contensou_drivers_equilibrium, only : equilibrium_command
   use contensou_drivers_eval, only : eval_command
   use contensou_drivers_export, only : export_command
   use contensou_drivers_fmu, only : fmu_command
   use contensou_drivers_help, only : help_command
   use contensou_drivers_merge, only : merge_command
   use contensou_drivers_models, only : models_command
   use contensou_drivers_new, only : new_command
   use contensou_drivers_run, only : run_command
   use contensou_drivers_sweep, only : sweep_command
   use contensou_drivers_version, only : version_command
   use contensou_drivers_view, only : view_command
   implicit none(type, external)
   private

   public :: all_commands

contains

   !> The commands, in the order of the usage.
   subroutine all_commands(commands)
      type(command_type), allocatable, intent(out) :: commands(:)

      allocate(commands(0))
      call add(commands, new_command())
      call add(commands, run_command())
      call add(commands, check_command())
      call add(commands, models_command())
      call add(commands, eval_command())
      call add(commands, equilibrium_command())
      call add(commands, bearing_command())
      call add(commands, cost_command())
      call add(commands, bench_command())
      call add(commands, diff_command())
      call add(commands, view_command())
      call add(commands, export_command())
      call add(commands, fmu_command())
      call add(commands, sweep_command())
      call add(commands, merge_command())
      call add(commands, help_command())
      call add(commands, version_command())
   end subroutine all_commands

   subroutine add(commands, command)
      type(command_type), allocatable, intent(inout) :: commands(:)
      type(command_type), intent(in) :: command
      type(command_type), allocatable :: longer(:)

      ! Not an array constructor: gfortran 12 frees the components of its elements twice.
      allocate(longer(size(commands) + 1))
      longer(:size(commands)) = commands
      longer(size(longer)) = command
      ! Of no options gfortran 12 keeps no array.
      if (.not. allocated(longer(size(longer))%options)) allocate(longer(size(longer))%options(0))
      call move_alloc(longer, commands)
   end subroutine add

end module contensou_drivers_commands
