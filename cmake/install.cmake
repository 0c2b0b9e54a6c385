# SPDX-License-Identifier: GPL-3.0-or-later
# cmake --install DIR --prefix PREFIX [--component programs|participant]
#   programs      the executables, into bin/
#   participant   the SDK: a CMake package (find_package(drogue)) with drogue::participant (C++) and
#                 drogue::participant_c (the C functions, one shared library), headers, and the Python modules
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME participant)
set(drogue_headers ${CMAKE_INSTALL_INCLUDEDIR}/drogue)
set(drogue_package ${CMAKE_INSTALL_LIBDIR}/cmake/drogue)

install(TARGETS coupler fluid_solver structure_solver mesh_mover parachute_mesher
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)

install(TARGETS drogue_proto drogue_base drogue_participant drogue_participant_c EXPORT drogue
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT participant
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT participant NAMELINK_COMPONENT participant
        INCLUDES DESTINATION ${drogue_headers})
set_target_properties(drogue_proto PROPERTIES EXPORT_NAME proto)
set_target_properties(drogue_base PROPERTIES EXPORT_NAME base)
set_target_properties(drogue_participant PROPERTIES EXPORT_NAME participant)
install(EXPORT drogue NAMESPACE drogue:: FILE drogueTargets.cmake DESTINATION ${drogue_package} COMPONENT participant)

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/drogueConfig.cmake.in ${CMAKE_BINARY_DIR}/drogueConfig.cmake
                              INSTALL_DESTINATION ${drogue_package})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/drogueConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/drogueConfig.cmake ${CMAKE_BINARY_DIR}/drogueConfigVersion.cmake
        DESTINATION ${drogue_package} COMPONENT participant)

install(FILES participant/c/drogue_participant.h participant/c/drogue_participant.f90 DESTINATION ${drogue_headers} COMPONENT participant)
install(FILES participant/cpp/participant.hpp participant/cpp/subcycled.hpp DESTINATION ${drogue_headers}/participant/cpp COMPONENT participant)
install(FILES common/base/result.hpp DESTINATION ${drogue_headers}/common/base COMPONENT participant)
install(FILES ${CMAKE_BINARY_DIR}/proto/drogue/v1/wire.pb.h DESTINATION ${drogue_headers}/drogue/v1 COMPONENT participant)
install(FILES proto/drogue/v1/wire.proto DESTINATION ${CMAKE_INSTALL_DATADIR}/drogue COMPONENT participant)
install(DIRECTORY ${DROGUE_PYTHON_DIR}/drogue DESTINATION ${CMAKE_INSTALL_DATADIR}/drogue/python COMPONENT participant
        PATTERN __pycache__ EXCLUDE)
