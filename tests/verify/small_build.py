"""A build of three small patches, for tests that look at its files."""

#: Two bowed panels of one roof, sewn along its ridge, and a wall that is cut on the fold from a material that gives.
PROJECT = """\
flatnet: 1
name: roof
edge_length: 25
nodes:
  a: [0, 0, 0]
  b: [200, 0, 0]
  c: [200, 120, 60]
  d: [0, 120, 60]
  e: [200, 260, 0]
  f: [0, 260, 0]
  g: [200, 0, -90]
  h: [0, 0, -90]
curves:
  eaves: {kind: spline, from: a, to: b, points: [[100, -10, 25]], normals: {left: [0, -0.5, 1], right: [0, -1, 0.2]}}
  right: {kind: spline, from: b, to: c, points: [[200, 60, 40]], normals: [0.2, -0.5, 1]}
  ridge: {kind: spline, from: c, to: d, points: [[100, 120, 85]], normals: [0, 0, 1], notches: 60}
  left: {kind: spline, from: d, to: a, points: [[0, 60, 40]], normals: [-0.2, -0.5, 1]}
  right_back: {kind: spline, from: c, to: e, points: [[200, 190, 45]], normals: [0.2, 0.5, 1]}
  back: {kind: spline, from: e, to: f, points: [[100, 265, 15]], normals: [0, 0.5, 1], nicks: {every: 20, radius: 2000}}
  left_back: {kind: spline, from: f, to: d, points: [[0, 190, 45]], normals: [-0.2, 0.5, 1]}
  down_right: {from: b, to: g, normals: [0.1, -1, 0.1]}
  foot: {kind: spline, from: g, to: h, points: [[100, -25, -90]], normals: [0, -1, 0]}
  down_left: {from: h, to: a, normals: [-0.1, -1, 0.1]}
patches:
  front:
    around: [eaves, right, ridge, left]
    material: cloth
    cut: 1
    mirrored: 1
    grain: [1, 0, 0]
    marks:
      lamp: {at: [100, 60, 50], kind: eyelet, diameter: 6}
      ladder: {points: [[60, 30, 30], [140, 40, 30]], kind: stitch}
  back: {around: [-ridge, right_back, back, left_back], material: cloth, grain: [0, 1, 0]}
  wall: {around: [-eaves, -down_left, -foot, -down_right], material: leather, grain: [1, 0, 0], fold: down_left}
rest: openings
materials:
  cloth: {width: 500, gap: 3, allowance: 10}
  leather: {width: 400, gap: 2, allowance: 4, rotations: free, strain: 0.02}
nesting: {seconds: 1}
"""
