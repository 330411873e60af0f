"""Campaigns: many runs over seeds and options, on every core, with one call."""

from robsim.campaigns.launch import campaign
from robsim.campaigns.result import CampaignResult
from robsim.campaigns.spec import CampaignSpec, Case
from robsim.campaigns.summary import CampaignSummary

__all__ = ["CampaignResult", "CampaignSpec", "CampaignSummary", "Case", "campaign"]
