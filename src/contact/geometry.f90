!> Geometry part of a contact: where two surfaces are closest, and how they curve there.
!>
!> Conventions: the normal points from A into B; the gap is negative when the surfaces overlap; the
!> contact point is where the undeformed surfaces are closest: midway between the two closest
!> points, against a plane the one of the curved surface.
!> A closed form for a pair of shapes is an extension of `geometry_type` and a row in `pairs`.
module contensou_contact_geometry
   use contensou_base_checkpoint, only : checkpoint_type
   use contensou_base_kinds, only : wp
   use contensou_contact_shapes_shape, only : apex_curvature
   implicit none(type, external)
   private

   public :: pose_type, contact_point_type, contact_variation_type, track_type, geometry_type
   public :: contact_motion_type, rolling_velocity, unbounded
   public :: place_closest, place_own, place_none, same_place
   public :: contact_trouble, search_trouble, trouble_text
   public :: trouble_none, trouble_lost, trouble_conforming, trouble_no_spot, &
      trouble_jammed, trouble_redundant, trouble_apex, trouble_sunk, trouble_pulls, &
      trouble_drives
   public :: trouble_far, trouble_sudden, trouble_spots, trouble_endless, trouble_squeezed, &
      trouble_unsettled, trouble_unseen, trouble_merged, trouble_missed, trouble_still, &
      trouble_apart

   !> What can make a contact unusable: nothing, a search without result, surfaces that do not touch
   !> in a point, a formula for the spot that gives none, friction that jams a rigid contact, rigid
   !> contacts that do not determine their forces, an apex that touches.
   integer, parameter :: trouble_none = 0, trouble_lost = 1, trouble_conforming = 2, &
      trouble_no_spot = 3, trouble_jammed = 4, trouble_redundant = 5, &
      trouble_apex = 6, trouble_sunk = 7, trouble_pulls = 8, trouble_drives = 9, &
      trouble_endless = 10, trouble_squeezed = 11, trouble_unsettled = 12

   !> More of it: positions too large for their rounding, an overlap that no motion explains, a
   !> place where the surfaces touch without a spot, two spots that become one under load, a touch
   !> or a lift-off that went unnoticed, a law of creep that has no value without rolling, a closed
   !> rigid contact whose surfaces are apart.
   integer, parameter :: trouble_far = 20, trouble_sudden = 21, trouble_spots = 22, &
      trouble_unseen = 23, trouble_merged = 24, trouble_missed = 25, trouble_still = 26, &
      trouble_apart = 27

   !> What a track follows: the closest place; one that it keeps, however close others are, as each
   !> spot of a contact that has several; none.
   integer, parameter :: place_closest = 0, place_own = 1, place_none = 2

   !> Distance of two places over the size of the surfaces above which they are not the same.
   real(wp), parameter :: distinct = 1.0e-4_wp

   !> Ratio A/B below which a spot counts as a line.
   real(wp), parameter :: conforming_ratio = 1.0e-8_wp

   !> As good as infinite, for products with it: the curvature of a tip [1/m], the reach of a
   !> surface without an end [m], the sharpness of a gap where surfaces conform, over the curvature.
   real(wp), parameter :: unbounded = 1.0e100_wp

   !> Position and motion of a body, inertial frame.
   type :: pose_type
      !> Whether this is the ground, whose pose is that of the inertial frame at rest: the values
      !> below are those for good, and products with them can be spared.
      logical :: ground = .false.
      !> Centre of mass [m].
      real(wp) :: position(3) = 0.0_wp
      !> Rotation matrix, body to inertial.
      real(wp) :: rotation(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
      !> Velocity of the centre of mass [m/s].
      real(wp) :: velocity(3) = 0.0_wp
      !> Angular velocity [rad/s].
      real(wp) :: spin(3) = 0.0_wp
   end type pose_type

   !> Geometry of a contact at an instant, inertial frame.
   type :: contact_point_type
      !> Signed distance of the undeformed surfaces, negative for overlap [m].
      real(wp) :: gap
      !> Contact point [m].
      real(wp) :: point(3)
      !> Unit normal from A into B.
      real(wp) :: normal(3)
      !> Unit tangent along the major axis of the spot.
      real(wp) :: major(3)
      !> Half of the smaller relative principal curvature [1/m].
      real(wp) :: curvature_a
      !> Half of the larger relative principal curvature [1/m].
      real(wp) :: curvature_b
   end type contact_point_type

   !> Where a contact is and how it moves, inertial frame.
   type :: contact_motion_type
      type(contact_point_type) :: at
      !> Velocity of B against A at the contact point [m/s].
      real(wp) :: velocity(3)
      !> Angular velocity of B against A [rad/s].
      real(wp) :: spin(3)
   contains
      procedure :: gap_rate
   end type contact_motion_type

   !> How a contact point changes when B moves against A, A at rest, to first order in a twist of B:
   !> the translation (1:3) [m] of the point of B at the contact point and the rotation (4:6) [rad],
   !> inertial frame.
   type :: contact_variation_type
      !> Change of the contact point per twist [-, m/rad].
      real(wp) :: point(3, 6)
      !> Change of the normal per twist [1/m, 1/rad].
      real(wp) :: normal(3, 6)
      !> Rotation of the major axis about the normal per twist [rad/m, -].
      real(wp) :: turn(6)
      !> Change of `curvature_a` per twist [1/m2, 1/m].
      real(wp) :: curvature_a(6)
      !> Change of `curvature_b` per twist [1/m2, 1/m].
      real(wp) :: curvature_b(6)
   end type contact_variation_type

   !> What a search remembers of a contact from one state to the next.
   type :: track_type
      !> Whether the closest points are known.
      logical :: known = .false.
      !> Whether the last search failed.
      logical :: lost = .false.
      !> Closest point of surface A, frame of the surface [m].
      real(wp) :: first(3) = 0.0_wp
      !> Closest point of surface B, frame of the surface [m].
      real(wp) :: second(3) = 0.0_wp
      !> Normal of one of the surfaces there, in its frame.
      real(wp) :: normal(3) = 0.0_wp
      !> Distance below which no other place lay when all of the surfaces were last looked at [m].
      real(wp) :: elsewhere = -huge(1.0_wp)
      !> Frame of surface B seen from surface A at that time: rotation matrix.
      real(wp) :: rotation(3, 3) = 0.0_wp
      !> Its origin [m].
      real(wp) :: origin(3) = 0.0_wp
      !> One of the `place_*` codes.
      integer :: place = place_closest
      !> Whether there was no such place at the last search: there is nothing to locate.
      logical :: away = .false.
      !> Whether the surfaces overlapped when a place of its own was found last.
      logical :: overlaps = .false.
      !> Whether a rigid contact is closed there.
      logical :: pinned = .false.
      !> Where a place of its own was when all were looked for last, on A and on B, in their frames
      !> [m], and how far from there it may be found: half the distance of the next one [m].
      real(wp) :: anchor(3, 2) = 0.0_wp
      real(wp) :: leash = huge(1.0_wp)
   contains
      procedure :: exchange => exchange_track
   end type track_type

   !> A pair of surfaces.
   type, abstract :: geometry_type
      !> Whether the relative curvatures never change.
      logical :: constant_curvatures = .true.
      !> Whether a gap is sought from where it was last: that of a pose depends on it, though by
      !> rounding only.
      logical :: searched = .false.
      !> Number of places where the surfaces may touch at the same time.
      integer :: most_spots = 1
      !> The surface on which these are put in order, 1 for A and 2 for B.
      integer :: ordering = 1
      !> Length of the order of the surfaces where there may be more than one [m].
      real(wp) :: length = 0.0_wp
      !> Largest curvature of what meets a surface that is concave somewhere [1/m]; 0 if both are
      !> convex.
      real(wp) :: into_hollow = 0.0_wp
   contains
      !> Gap alone.
      procedure(gap_interface), deferred :: gap
      !> All of the contact point.
      procedure(locate_interface), deferred :: locate
      !> Variation of the contact point.
      procedure(vary_interface), deferred :: vary
      !> All places where the gap is smallest among those near by, and below a limit.
      procedure :: find_places
      !> Mean curvature of the two surfaces in the axes of the spot.
      procedure(form_interface), deferred :: mean_form
      !> Smallest radius of curvature of the pair [m], the scale of admissible overlaps.
      procedure(radius_interface), deferred :: smallest_radius
   end type geometry_type

   abstract interface
      !> Signed distance of the surfaces [m].
      pure subroutine gap_interface(self, a, b, track, gap)
         import :: geometry_type, pose_type, track_type, wp
         implicit none(type, external)
         class(geometry_type), intent(in) :: self
         !> Pose of body A.
         type(pose_type), intent(in) :: a
         !> Pose of body B.
         type(pose_type), intent(in) :: b
         !> Where a search begins, and what it found; `lost` when it failed.
         type(track_type), intent(inout) :: track
         !> Gap [m].
         real(wp), intent(out) :: gap
      end subroutine gap_interface

      !> Contact point, normal, curvatures.
      pure subroutine locate_interface(self, a, b, track, gap, at)
         import :: geometry_type, pose_type, contact_point_type, track_type, wp
         implicit none(type, external)
         class(geometry_type), intent(in) :: self
         !> Pose of body A.
         type(pose_type), intent(in) :: a
         !> Pose of body B.
         type(pose_type), intent(in) :: b
         !> As `gap` left it.
         type(track_type), intent(in) :: track
         !> Gap of these poses, from `gap` [m].
         real(wp), intent(in) :: gap
         type(contact_point_type), intent(out) :: at
      end subroutine locate_interface

      !> Variation of the contact point with a twist of B against A.
      pure subroutine vary_interface(self, a, b, track, at, variation)
         import :: geometry_type, pose_type, contact_point_type, contact_variation_type, &
            track_type, wp
         implicit none(type, external)
         class(geometry_type), intent(in) :: self
         !> Pose of body A.
         type(pose_type), intent(in) :: a
         !> Pose of body B.
         type(pose_type), intent(in) :: b
         !> As `gap` left it.
         type(track_type), intent(in) :: track
         !> The contact of these poses, from `locate`.
         type(contact_point_type), intent(in) :: at
         type(contact_variation_type), intent(out) :: variation
      end subroutine vary_interface

      !> Half of the difference of the curvature forms of B and A: the spot lies at (1/2) r.L r
      !> along the normal.
      pure subroutine form_interface(self, a, b, track, at, form)
         import :: geometry_type, pose_type, contact_point_type, track_type, wp
         implicit none(type, external)
         class(geometry_type), intent(in) :: self
         !> Pose of body A.
         type(pose_type), intent(in) :: a
         !> Pose of body B.
         type(pose_type), intent(in) :: b
         !> As `gap` left it.
         type(track_type), intent(in) :: track
         !> The contact of these poses, from `locate`.
         type(contact_point_type), intent(in) :: at
         !> Components 11, 12, 22 along the major and the minor axis [1/m].
         real(wp), intent(out) :: form(3)
      end subroutine form_interface

      !> Smallest radius of curvature [m].
      pure function radius_interface(self) result(radius)
         import :: geometry_type, wp
         implicit none(type, external)
         class(geometry_type), intent(in) :: self
         real(wp) :: radius
      end function radius_interface
   end interface

contains

   !> All places where the gap is smallest among those near by, and below a limit; a closed form
   !> tells of none, as there is one.
   pure subroutine find_places(self, a, b, limit, places, gaps, n)
      class(geometry_type), intent(in) :: self
      type(pose_type), intent(in) :: a
      type(pose_type), intent(in) :: b
      !> The limit [m].
      real(wp), intent(in) :: limit
      !> The places; as many as there is room for.
      type(track_type), intent(inout) :: places(:)
      !> Their gaps [m].
      real(wp), intent(out) :: gaps(:)
      !> Number of places.
      integer, intent(out) :: n

      n = 0
      gaps = limit
   end subroutine find_places

   !> Rate of the gap, negative for approach [m/s].
   pure real(wp) function gap_rate(self)
      class(contact_motion_type), intent(in) :: self

      gap_rate = dot_product(self%velocity, self%at%normal)
   end function gap_rate

   !> Velocity at which the material of both bodies passes the spot, the mean of the two [m/s]; what
   !> is of it in the tangent plane counts. What rolls does so in the opposite direction.
   !>
   !> The spot moves over A by the variation of the contact point, u_A = P (v, w), and over B by
   !> u_B = u_A - v; c = -(u_A + u_B)/2. With the curvature tensors S of the two surfaces that is
   !> u_B = (S_A + S_B)^-1 (w x n - S_A v), without a division by a velocity. J. J. Kalker,
   !> Three-Dimensional Elastic Bodies in Rolling Contact, 1990, section 1.4.
   pure function rolling_velocity(variation, velocity, spin) result(carried)
      type(contact_variation_type), intent(in) :: variation
      !> Velocity of B against A at the contact point [m/s].
      real(wp), intent(in) :: velocity(3)
      !> Angular velocity of B against A [rad/s].
      real(wp), intent(in) :: spin(3)
      real(wp) :: carried(3)
      real(wp) :: twist(6)

      twist = [velocity, spin]
      carried = 0.5_wp*velocity - matmul(variation%point, twist)
   end function rolling_velocity

   !> Whether two tracks are at the same place.
   pure logical function same_place(one, other, size)
      type(track_type), intent(in) :: one
      type(track_type), intent(in) :: other
      !> Length of the order of the surfaces [m].
      real(wp), intent(in) :: size

      same_place = max(sum((one%first - other%first)**2), sum((one%second - other%second)**2)) &
         <= (distinct*size)**2
   end function same_place

   !> Write a track to a checkpoint or read it back.
   subroutine exchange_track(self, checkpoint)
      class(track_type), intent(inout) :: self
      type(checkpoint_type), intent(inout) :: checkpoint

      call checkpoint%exchange("track_known", self%known)
      call checkpoint%exchange("track_first", self%first)
      call checkpoint%exchange("track_second", self%second)
      call checkpoint%exchange("track_normal", self%normal)
      call checkpoint%exchange("track_elsewhere", self%elsewhere)
      call checkpoint%exchange("track_rotation", self%rotation)
      call checkpoint%exchange("track_origin", self%origin)
      call checkpoint%exchange("track_place", self%place)
      if (self%place == place_closest) return
      call checkpoint%exchange("track_away", self%away)
      call checkpoint%exchange("track_overlaps", self%overlaps)
      call checkpoint%exchange("track_pinned", self%pinned)
      call checkpoint%exchange("track_anchor", self%anchor)
      call checkpoint%exchange("track_leash", self%leash)
   end subroutine exchange_track

   !> What is wrong with a contact, one of the `trouble_*` codes.
   !>
   !> To be asked where the surfaces overlap: open surfaces may conform without harm.
   pure function contact_trouble(track, at) result(trouble)
      !> The search that found the contact.
      type(track_type), intent(in) :: track
      type(contact_point_type), intent(in) :: at
      integer :: trouble

      trouble = search_trouble(track)
      if (trouble /= trouble_none) return
      if (max(abs(at%curvature_a), abs(at%curvature_b)) > 0.1_wp*apex_curvature) then
         trouble = trouble_apex
      else if (.not. at%curvature_a > conforming_ratio*abs(at%curvature_b)) then
         trouble = trouble_conforming
      end if
   end function contact_trouble

   !> What is wrong with a search. A place that is not there any more though the surfaces overlap
   !> has become one with another.
   pure integer function search_trouble(track) result(trouble)
      type(track_type), intent(in) :: track

      trouble = trouble_none
      if (track%lost) trouble = merge(trouble_lost, trouble_merged, track%place == place_closest)
   end function search_trouble

   !> A trouble in words that follow the names of the surfaces.
   pure function trouble_text(trouble) result(text)
      !> One of the `trouble_*` codes.
      integer, intent(in) :: trouble
      character(len=:), allocatable :: text

      select case (trouble)
      case (trouble_lost)
         text = "the search for the closest points of the surfaces has failed"
      case (trouble_conforming)
         text = "the surfaces conform: they touch along a line or an area, not in a point"
      case (trouble_no_spot)
         text = "the formula for the ellipse gives no spot for these curvatures; 'power' or " // &
            "'exact' does"
      case (trouble_jammed)
         text = "friction jams the rigid contact: no normal force keeps it closed (the " // &
            "paradox of Painleve); normal = 'hertz' has no such case"
      case (trouble_redundant)
         text = "the rigid contacts that are closed together do not determine their forces; " // &
            "normal = 'hertz' for some of them does"
      case (trouble_sunk)
         text = "the surfaces of the rigid contact overlap by more than 1e-6 of the smallest " // &
            "radius; a smaller integrator.rtol or integrator.max_step holds them"
      case (trouble_apart)
         text = "the surfaces of the closed rigid contact are apart by more than 1e-6 of the " // &
            "smallest radius; a smaller integrator.rtol or integrator.max_step holds them"
      case (trouble_pulls)
         text = "the closed rigid contact pulls, and no set of closed contacts pushes " // &
            "everywhere; normal = 'hertz' for some of them has no such case"
      case (trouble_drives)
         text = "friction of the rigid contact supplies energy, which no law of friction may"
      case (trouble_endless)
         text = "the impacts of contacts that touch at once, one after the other, do not come " // &
            "to an end; scene.impacts = 'simultaneous' takes them together, and normal = " // &
            "'hertz' knows no instant"
      case (trouble_squeezed)
         text = "bodies that do not yield press together what lies between them, and no " // &
            "impulses of the rigid contacts stop that; normal = 'hertz' yields"
      case (trouble_unsettled)
         text = "the impulses with friction of contacts that touch at once were not found; " // &
            "scene.impacts = 'sequential' takes one after the other"
      case (trouble_unseen)
         text = "the surfaces touch and part in less time than the rounding of the time " // &
            "resolves; a scene that begins nearer to it does"
      case (trouble_apex)
         text = "the apex of the cone touches, where its surface has no curvature"
      case (trouble_sudden)
         text = "the surfaces overlap without having approached: their closest points have " // &
            "jumped, as where they can touch in several places; a contact of its own for each " // &
            "place, with surfaces that touch only there, does not"
      case (trouble_spots)
         text = "the surfaces touch in more places at once than the contact has spots; a " // &
            "contact of its own for each place, with surfaces that touch only there, knows all"
      case (trouble_merged)
         text = "two spots that touch become one, or one becomes two: there the surfaces " // &
            "conform, and no spot is one of Hertz's. A body in a hollow that is wider than " // &
            "the largest radius of curvature of the body, a^2/c of an ellipsoid, has one " // &
            "spot from the start"
      case (trouble_missed)
         text = "a touch or a lift-off was missed: the contact counts as closed where its " // &
            "surfaces are apart, or as open where they overlap; an integrator.max_step below " // &
            "the time that it takes to touch and part finds it"
      case (trouble_still)
         text = "where nothing rolls its law of creep has no value; creep = 'table', the " // &
            "default, has one"
      case (trouble_far)
         text = "its bodies are so far from the origin that the rounding of their positions " // &
            "is not small against the overlap; an origin near where they touch resolves it"
      case default
         text = ""
      end select
   end function trouble_text

end module contensou_contact_geometry
