! SPDX-License-Identifier: GPL-3.0-or-later
! The structure of examples/cpp_spring in Fortran: a rigid unit square on a spring, m a + k d = f along z, released from
! rest. Time: the trapezoidal rule.
!
!     spring MASS STIFFNESS START --connect ENDPOINT
module spring_solver
  use, intrinsic :: iso_c_binding
  use drogue_participant
  implicit none

  integer, parameter :: nodes = 4
  real(c_double), target :: points(3, nodes) = reshape([0d0, 0d0, 0d0, 1d0, 0d0, 0d0, 1d0, 1d0, 0d0, 0d0, 1d0, 0d0], [3, nodes])
  integer(c_int64_t), target :: corners(nodes) = [0, 1, 2, 3]
  type(drogue_elements), target :: square

  type :: motion
    real(c_double) :: d = 0, v = 0, a = 0
  end type
  type(motion) :: now, at_n
  real(c_double) :: mass, stiffness, start, dt

contains

  integer(c_int) function initialize(user, interface, call) bind(c)
    type(c_ptr), value :: user, call
    type(drogue_interface), intent(inout) :: interface
    square = drogue_elements(DROGUE_QUADRANGLES4, 1_c_size_t, c_loc(corners))
    interface%node_count = nodes
    interface%points = c_loc(points)
    interface%block_count = 1
    interface%blocks = c_loc(square)
    interface%mesh_node_count = nodes
    at_n = motion(start, 0d0, -stiffness/mass*start)
    initialize = DROGUE_OK
  end function

  integer(c_int) function begin_step(user, step, call) bind(c)
    type(c_ptr), value :: user, call
    type(drogue_step), intent(in) :: step
    dt = step%time_step
    begin_step = DROGUE_OK
  end function

  integer(c_int) function iterate(user, call, report) bind(c)
    type(c_ptr), value :: user, call
    type(drogue_report), intent(inout) :: report
    real(c_double), pointer :: force(:, :), displacement(:, :), velocity(:, :)
    real(c_double) :: guess
    call c_f_pointer(drogue_input(call, "force"//c_null_char), force, [3, nodes])
    call c_f_pointer(drogue_output(call, "displacement"//c_null_char), displacement, [3, nodes])
    call c_f_pointer(drogue_output(call, "velocity"//c_null_char), velocity, [3, nodes])
    guess = at_n%d + dt*at_n%v + 0.25d0*dt**2*at_n%a
    now%a = (sum(force(3, :)) - stiffness*guess)/(mass + 0.25d0*dt**2*stiffness)
    now%d = guess + 0.25d0*dt**2*now%a
    now%v = at_n%v + 0.5d0*dt*(at_n%a + now%a)
    displacement(3, :) = now%d - start ! since initialize
    velocity(3, :) = now%v
    report%converged = 1
    iterate = DROGUE_OK
  end function

  integer(c_int) function commit(user, write_output, call) bind(c)
    type(c_ptr), value :: user, call
    integer(c_int), value :: write_output
    at_n = now
    commit = DROGUE_OK
  end function

  integer(c_int) function rollback(user, call) bind(c)
    type(c_ptr), value :: user, call
    now = at_n
    rollback = DROGUE_OK
  end function

  integer(c_int) function checkpoint(user, directory, call) bind(c)
    type(c_ptr), value :: user, directory, call
    integer :: unit, status
    open (newunit=unit, file=drogue_text(directory)//"/motion", form="unformatted", iostat=status)
    if (status == 0) write (unit, iostat=status) at_n%d, at_n%v, at_n%a
    if (status == 0) close (unit, iostat=status)
    checkpoint = merge(DROGUE_OK, DROGUE_INTERNAL, status == 0)
  end function

  integer(c_int) function restore(user, directory, call) bind(c)
    type(c_ptr), value :: user, directory, call
    integer :: unit, status
    open (newunit=unit, file=drogue_text(directory)//"/motion", form="unformatted", status="old", iostat=status)
    if (status == 0) read (unit, iostat=status) at_n%d, at_n%v, at_n%a
    if (status == 0) close (unit)
    if (status /= 0) call drogue_explain(call, "cannot read the spring's state"//c_null_char)
    restore = merge(DROGUE_OK, DROGUE_CONFIG, status == 0)
  end function

end module spring_solver

program spring
  use, intrinsic :: iso_c_binding
  use drogue_participant
  use spring_solver
  implicit none
  character(kind=c_char, len=7), target :: software = "spring"//c_null_char
  character(kind=c_char, len=6), target :: force = "force"//c_null_char
  character(kind=c_char, len=13), target :: displacement = "displacement"//c_null_char
  character(kind=c_char, len=9), target :: velocity = "velocity"//c_null_char
  type(drogue_field), target :: inputs(1), outputs(2)
  type(drogue_solver) :: solver
  character(256) :: argument
  integer :: i, status

  call read_number(1, mass)
  call read_number(2, stiffness)
  call read_number(3, start)
  inputs(1) = drogue_field(c_loc(force), DROGUE_FORCE, DROGUE_INTERFACE_NODES, 3)
  outputs(1) = drogue_field(c_loc(displacement), DROGUE_DISPLACEMENT, DROGUE_INTERFACE_NODES, 3)
  outputs(2) = drogue_field(c_loc(velocity), DROGUE_VELOCITY, DROGUE_INTERFACE_NODES, 3)
  solver%software = c_loc(software)
  solver%can_rollback = 1
  solver%can_checkpoint = 1
  solver%inputs = c_loc(inputs)
  solver%input_count = size(inputs)
  solver%outputs = c_loc(outputs)
  solver%output_count = size(outputs)
  solver%initialize = c_funloc(initialize)
  solver%begin_step = c_funloc(begin_step)
  solver%iterate = c_funloc(iterate)
  solver%commit = c_funloc(commit)
  solver%rollback = c_funloc(rollback)
  solver%checkpoint = c_funloc(checkpoint)
  solver%restore = c_funloc(restore)
  do i = 1, command_argument_count() - 1
    call get_command_argument(i, argument)
    if (argument /= "--connect") cycle
    call get_command_argument(i + 1, argument)
    status = drogue_serve(solver, trim(argument)//c_null_char)
    if (status /= DROGUE_OK) call exit(status)
    stop
  end do
  call exit(DROGUE_CONFIG)

contains

  subroutine read_number(position, number)
    integer, intent(in) :: position
    real(c_double), intent(out) :: number
    character(64) :: text
    integer :: failure
    call get_command_argument(position, text)
    read (text, *, iostat=failure) number
    if (failure /= 0) call exit(DROGUE_CONFIG)
  end subroutine

end program spring
