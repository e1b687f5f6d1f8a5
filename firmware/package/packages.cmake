# cpack: the Debian packages strobed (firmware), strobe (host, simulator, message types) and strobe-camera (drivers of
# cameras, with the libraries that only they need); see firmware/README.md.
set(STROBE_PACKAGES strobed)
if(NOT STROBE_FIRMWARE_ONLY)
  list(APPEND STROBE_PACKAGES strobe strobe-camera)
endif()

# What packages of each release depend on differs, so their versions do.
set(release "")
set(os_release ${CMAKE_SYSROOT}/etc/os-release)
if(EXISTS ${os_release})
  file(STRINGS ${os_release} line REGEX "^VERSION_ID=")
  string(REGEX REPLACE "[^0-9.]" "" release "${line}")
endif()
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
if(release)
  string(APPEND CPACK_PACKAGE_VERSION "+deb${release}")
endif()

# Policy: each package has its licence and changelog.
foreach(package ${STROBE_PACKAGES})
  set(changelog ${PROJECT_BINARY_DIR}/packages/${package}/changelog)
  file(WRITE ${changelog}.new "${package} (${CPACK_PACKAGE_VERSION}) stable; urgency=medium\n\n"
       "  * See the history of the repository.\n\n -- Strobe <strobe@packages.invalid>  Sun, 22 Nov 2026 00:00:00 +0000\n")
  execute_process(COMMAND gzip -9nc ${changelog}.new OUTPUT_FILE ${changelog}.gz COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${changelog}.gz ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
          COMPONENT ${package})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME strobe)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "impact experiments by strobe photography")
set(CPACK_PACKAGE_CONTACT "Strobe <strobe@packages.invalid>")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_COMPONENTS_ALL ${STROBE_PACKAGES})
set(CPACK_SET_DESTDIR ON)  # so that the unit names where it will be
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
if(CMAKE_LIBRARY_ARCHITECTURE MATCHES "^aarch64")
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
endif()

set(CPACK_DEBIAN_STROBED_PACKAGE_NAME strobed)
set(CPACK_DEBIAN_STROBED_DESCRIPTION "strobed times two strobe lamps, a camera's shutter and a pitching machine over
GPIO lines, stamps what the flash sensors saw, keeps a journal and publishes
events over LCM. The systemd unit is enabled, but not started.")
# The user is made by systemd, or where a container has none by its tool alone.
set(CPACK_DEBIAN_STROBED_PACKAGE_DEPENDS "systemd-standalone-sysusers | systemd")
set(CPACK_DEBIAN_STROBED_PACKAGE_CONTROL_EXTRA
    "${CMAKE_CURRENT_LIST_DIR}/postinst;${CMAKE_CURRENT_LIST_DIR}/prerm;${CMAKE_CURRENT_LIST_DIR}/postrm")
set(CPACK_DEBIAN_STROBED_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_STROBE_PACKAGE_NAME strobe)
set(CPACK_DEBIAN_STROBE_DESCRIPTION "strobe fires series of shots at a rig that strobed runs, digitizes the
photographs and shows velocities, spin, restitution and friction after each
shot. strobe-sim stands in for the rig. The LCM message types are included, also
as Python modules and, where a JDK was there, as a jar for lcm-spy.")
set(CPACK_DEBIAN_STROBE_PACKAGE_RECOMMENDS "strobe-camera")
set(CPACK_DEBIAN_STROBE_PACKAGE_SUGGESTS "strobed, python3-numpy, parallel, liblcm-java")

set(CPACK_DEBIAN_STROBE-CAMERA_PACKAGE_NAME strobe-camera)
set(CPACK_DEBIAN_STROBE-CAMERA_DESCRIPTION "strobe's drivers of cameras: industrial ones (GigE Vision, USB3 Vision), those that
libgphoto2 knows, and the decoder of RAW files. Of use where a rig file names
such a camera, or photographs are RAW files.")
include(CPack)
