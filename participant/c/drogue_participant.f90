! SPDX-License-Identifier: GPL-3.0-or-later
!> drogue_participant.h for Fortran: the same types and functions, which that header documents. Compile this file with your
!> solver, and link libdrogue_participant. Strings that go in end with c_null_char; drogue_text() makes a Fortran string of
!> one that comes out.
module drogue_participant
  use, intrinsic :: iso_c_binding
  implicit none

  enum, bind(c)
    enumerator :: DROGUE_OK = 0, DROGUE_INTERNAL, DROGUE_CONFIG, DROGUE_NUMERICAL, DROGUE_PEER, DROGUE_INTERRUPTED, DROGUE_RETRY
  end enum
  enum, bind(c)
    enumerator :: DROGUE_DISPLACEMENT = 1, DROGUE_VELOCITY, DROGUE_FORCE, DROGUE_PRESSURE, DROGUE_TRACTION, &
                  DROGUE_TRANSLATION, DROGUE_QUALITY
  end enum
  enum, bind(c)
    enumerator :: DROGUE_INTERFACE_NODES = 1, DROGUE_MESH_NODES, DROGUE_GLOBAL
  end enum
  enum, bind(c)
    enumerator :: DROGUE_END_OF_STEP = 1, DROGUE_MEAN_OF_STEP
  end enum
  enum, bind(c)
    enumerator :: DROGUE_LINES = 0, DROGUE_LINES3, DROGUE_TRIANGLES, DROGUE_TRIANGLES6, DROGUE_QUADRANGLES4, DROGUE_QUADRANGLES9
  end enum

  type, bind(c) :: drogue_field
    type(c_ptr) :: name
    integer(c_int) :: quantity, location, components
    integer(c_int) :: time_level = DROGUE_END_OF_STEP, optional = 0
  end type
  type, bind(c) :: drogue_elements
    integer(c_int) :: kind
    integer(c_size_t) :: count
    type(c_ptr) :: nodes
  end type
  type, bind(c) :: drogue_interface
    integer(c_size_t) :: node_count
    type(c_ptr) :: points, reference, material, velocity
    integer(c_size_t) :: block_count
    type(c_ptr) :: blocks, mesh_nodes
    integer(c_int64_t) :: mesh_node_count
    type(c_ptr) :: mesh_hash
  end type
  type, bind(c) :: drogue_run
    type(c_ptr) :: directory
    real(c_double) :: start_time, time_step
    integer(c_int) :: resume
  end type
  type, bind(c) :: drogue_step
    integer(c_int64_t) :: step
    integer(c_int32_t) :: attempt
    real(c_double) :: time, time_step
  end type
  type, bind(c) :: drogue_report
    integer(c_int32_t) :: inner_iterations
    real(c_double) :: inner_residual
    integer(c_int) :: converged, fixed_iterations
  end type
  type, bind(c) :: drogue_solver
    type(c_ptr) :: software
    integer(c_int) :: can_rollback = 0, can_checkpoint = 0, variable_step = 1
    type(c_ptr) :: inputs
    integer(c_size_t) :: input_count
    type(c_ptr) :: outputs
    integer(c_size_t) :: output_count
    type(c_ptr) :: user = c_null_ptr
    type(c_funptr) :: configure = c_null_funptr, initialize = c_null_funptr, begin_step = c_null_funptr, &
                      iterate = c_null_funptr, commit = c_null_funptr, rollback = c_null_funptr, &
                      checkpoint = c_null_funptr, restore = c_null_funptr
  end type

  interface
    integer(c_int) function drogue_serve(solver, endpoint) bind(c)
      import :: drogue_solver, c_char, c_int
      type(drogue_solver), intent(in) :: solver
      character(kind=c_char), intent(in) :: endpoint(*)
    end function
    type(c_ptr) function drogue_input(call, name) bind(c)
      import :: c_ptr, c_char
      type(c_ptr), value :: call
      character(kind=c_char), intent(in) :: name(*)
    end function
    type(c_ptr) function drogue_output(call, name) bind(c)
      import :: c_ptr, c_char
      type(c_ptr), value :: call
      character(kind=c_char), intent(in) :: name(*)
    end function
    subroutine drogue_explain(call, text) bind(c)
      import :: c_ptr, c_char
      type(c_ptr), value :: call
      character(kind=c_char), intent(in) :: text(*)
    end subroutine
    integer(c_size_t) function drogue_strlen(text) bind(c, name="strlen")
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function
  end interface

contains

  function drogue_text(text) result(string)
    type(c_ptr), value :: text
    character(:), allocatable :: string
    character(kind=c_char), pointer :: letters(:)
    integer :: i
    call c_f_pointer(text, letters, [drogue_strlen(text)])
    allocate (character(size(letters)) :: string)
    do i = 1, size(letters)
      string(i:i) = letters(i)
    end do
  end function

end module drogue_participant
