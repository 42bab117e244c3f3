!> The groups and keys of a sweep file: one table, from which it is checked and `contensou help`
!> documents it.
module contensou_sweep_schema
   use contensou_base_kinds, only : wp
   use contensou_base_schema, only : any_number, group_spec_type, key_list_type, key_type, &
      kind_any, kind_choice, kind_file, kind_integer, kind_real, kind_text, new_schema, schema_type
   use contensou_base_text, only : string_type, strings
   use contensou_scene_schema, only : constants_group_spec, put_constant_keys
   use contensou_study_quantities, only : row_quantities
   use contensou_study_quantity, only : quantity_type
   use contensou_sweep_sampling, only : sampling_names
   implicit none(type, external)
   private

   public :: sweep_schema, sweep_groups, sweep_keys
   public :: vary_names, vary_list, vary_linear, vary_log
   public :: keep_names, most_cases

   !> Largest number of cases.
   real(wp), parameter :: most_cases = 2.0_wp**40

   !> How a parameter varies.
   character(len=*), parameter :: vary_names(*) = [character(len=6) :: "list", "linear", "log"]

   !> Over the values of a list.
   integer, parameter :: vary_list = 1

   !> Between two numbers, evenly.
   integer, parameter :: vary_linear = 2

   !> Between two positive numbers, evenly in the logarithm.
   integer, parameter :: vary_log = 3

   !> What can be kept, beside single scalars and parts of the state.
   character(len=*), parameter :: keep_names(*) = [character(len=21) :: "summary", "events", &
      "final_state", "nothing"]

contains

   !> The groups of a sweep file with their keys.
   subroutine sweep_schema(schema)
      type(schema_type), intent(out) :: schema

      type(key_list_type) :: list

      list%keys = sweep_keys()
      list%n = size(list%keys)
      call put_constant_keys(list)
      call new_schema([sweep_groups(), constants_group_spec()], list%keys(:list%n), schema, &
         " in a sweep")
   end subroutine sweep_schema

   !> The groups of a sweep file that a scene does not have, in the order of the documentation.
   pure function sweep_groups() result(groups)
      type(group_spec_type), allocatable :: groups(:)

      allocate(groups(3))
      groups(1) = group_spec_type("sweep", .false., .true., &
         "many runs of a scene with other values: contensou sweep FILE runs them")
      groups(2) = group_spec_type("parameter", .true., .false., &
         "what varies from case to case, and how")
      groups(3) = group_spec_type("value", .true., .false., &
         "a value of the trajectory at a time, kept as a result of each case")
   end function sweep_groups

   !> The keys of all groups, in the order of the documentation.
   function sweep_keys() result(keys)
      type(key_type), allocatable :: keys(:)
      type(key_list_type) :: list

      call list%put("sweep", "scene", kind_file, mandatory=.true., &
         doc="file of the base scene, relative to the folder of the sweep file")
      call list%put("sweep", "sampling", kind_choice, words=sampling_names, default="'grid'", &
         doc="which cases there are: grid, every combination of the values of all parameters, " // &
         "the last parameter varies fastest; latin_hypercube; sobol, the sequence of the GNU " // &
         "Scientific Library; file, the rows of a table")
      call list%put("sweep", "cases", kind_integer, unit="1", least=1.0_wp, most=most_cases, &
         doc="number of cases of latin_hypercube and sobol; not for others")
      call list%put("sweep", "seed", kind_integer, unit="1", least=0.0_wp, most=2.0_wp**53, &
         doc="seed of latin_hypercube, 1 if not given; with sobol it shifts all points at " // &
         "random, and without there is no shift; not for others")
      call list%put("sweep", "table", kind_file, &
         doc="file of the cases for sampling = 'file', relative to the folder of the sweep " // &
         "file: CSV whose header names parameters by their paths, or HDF5 with a " // &
         "one-dimensional dataset for each, in its root or in /parameters")
      call list%put("sweep", "set", kind_text, values=any_number, &
         doc="settings for all cases, each a text as after --set: 'scene.t_end = 2'")
      call list%put("sweep", "keep", kind_text, values=any_number, default="'summary', 'events'", &
         doc="results that are kept: 'summary', all scalars of /summary; 'events', times of " // &
         "the first and last touch and lift-off and their numbers, for each contact; " // &
         "'final_state', position, velocity, angular_velocity and quaternion of each body; " // &
         "names of single ones of these; or 'nothing' of all that")
      call list%put("sweep", "trajectories", kind_integer, values=any_number, unit="1", &
         least=1.0_wp, most=most_cases, &
         doc="cases whose whole output file is kept, too, as NAME_case_N.h5 beside the table")
      call list%put("sweep", "time_limit", kind_real, unit="s", above=0.0_wp, &
         doc="wall time at which a case is given up; not given, there is no limit")
      call list%put("sweep", "output", kind_file, &
         doc="name of the table; not given, the name of the sweep file with .h5, in the " // &
         "current folder")

      call list%put("parameter", "name", kind_text, values=any_number, mandatory=.true., &
         doc="path of the setting as after --set, as 'top.angle' or 'top.position(3)'; with " // &
         "several paths all of them get the same value")
      call list%put("parameter", "vary", kind_choice, words=vary_names, &
         doc="how it varies: over a list, or evenly between two numbers or their logarithms; " // &
         "'list' if values are given, else 'linear'; not with sampling = 'file'")
      call list%put("parameter", "values", kind_any, values=any_number, &
         doc="the values of a list: numbers, texts such as names of models, or logicals")
      call list%put("parameter", "first", kind_real, &
         doc="first value of linear and log; with latin_hypercube and sobol a bound")
      call list%put("parameter", "last", kind_real, &
         doc="last value of linear and log; with latin_hypercube and sobol a bound")
      call list%put("parameter", "count", kind_integer, unit="1", least=1.0_wp, most=most_cases, &
         doc="number of values of linear and log in a grid; not for other samplings")
      call list%put("parameter", "column", kind_text, &
         doc="name of its column in the table; the first path if not given")

      call list%put("value", "name", kind_text, mandatory=.true., &
         doc="name of its column in the table")
      call list%put("value", "dataset", kind_choice, choices=datasets, mandatory=.true., &
         doc="dataset of /trajectory that it is taken from")
      call list%put("value", "of", kind_text, &
         doc="body, contact or spring that it belongs to; may be left out if there is one only")
      call list%put("value", "component", kind_integer, unit="1", least=1.0_wp, most=4.0_wp, &
         doc="component of a vector, from 1: x, y, z; w, x, y, z of a quaternion; major, " // &
         "minor of semi_axes; not for others")
      call list%put("value", "time", kind_real, unit="s", mandatory=.true., least=0.0_wp, &
         doc="simulated time of the value; beyond t_end of a case there is none")
      allocate(keys, source=list%keys(:list%n))
   end function sweep_keys

   !> Quantities of a row, without the time.
   function datasets() result(names)
      type(string_type), allocatable :: names(:)
      type(quantity_type), allocatable :: quantities(:)

      quantities = row_quantities()
      names = strings(quantities(2:)%name)
   end function datasets

end module contensou_sweep_schema
