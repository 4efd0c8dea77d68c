"""The rig in the picture: walls, exits and scale, found once and watched for a bump."""
